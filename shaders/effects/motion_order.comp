// Offsets in the list of each word's moving pixels, and the draws of them all. One work group.
// In: a bit for each moving pixel. Out: the number of moving pixels before each word; indirect
// draws of draw_quads quads each.
// Source: Hillis and Steele 1986, Data Parallel Algorithms (the scan); a fixed order makes two runs
// identical to the last bit.
#define THREADS 256
layout(local_size_x = THREADS) in;
uniform int words;
uniform int draws;      // capacity
uniform int draw_quads; // quads in one draw
struct Draw { uint count, instances, first, base_vertex, base_instance; };
layout(std430, binding = 1) readonly buffer Masks { uint masks[]; };
layout(std430, binding = 2) writeonly buffer Before { uint before[]; };
layout(std430, binding = 3) writeonly buffer Draws { Draw draw[]; };
shared uint sums[THREADS];

void main() {
    int me = int(gl_LocalInvocationIndex), each = (words + THREADS - 1) / THREADS;
    int begin = min(me * each, words), end = min(begin + each, words);
    uint sum = 0u;
    for (int k = begin; k < end; ++k) sum += uint(bitCount(masks[k]));
    sums[me] = sum;
    barrier();
    for (int reach = 1; reach < THREADS; reach *= 2) {
        uint lower = me >= reach ? sums[me - reach] : 0u;
        barrier();
        sums[me] += lower;
        barrier();
    }
    uint start = sums[me] - sum;
    for (int k = begin; k < end; ++k) {
        before[k] = start;
        start += uint(bitCount(masks[k]));
    }
    for (int k = me; k < draws; k += THREADS) {
        int left = clamp(int(sums[THREADS - 1]) - k * draw_quads, 0, draw_quads);
        draw[k] = Draw(uint(left * 6), 1u, 0u, uint(k * draw_quads * 4), 0u);
    }
}
