// Turn counts of things to draw into offsets in a list, and write the draw calls. One work group.
// In: counts of each group or chunk. Out: their prefix sums; indirect draws of draw_quads quads
// each, or of all triangles.
// Source: Hillis and Steele 1986, Data Parallel Algorithms (the scan); a fixed order makes two runs
// identical to the last bit.
#define THREADS 256
#include "warps/mesh_draws.glsl"
layout(local_size_x = THREADS) in;
uniform ivec2 draws;     // capacity: of cells, of pieces
uniform int draw_quads;  // quads in one draw
shared uvec2 sums[THREADS];

#if CHUNKS
layout(std430, binding = 8) buffer Chunks { uint totals[]; };
#else
layout(std430, binding = 1) buffer Groups { uvec2 totals[]; };
uniform int group_count;
#endif

Draw draw_of(int k, uint quads) {
    int left = clamp(int(quads) - k * draw_quads, 0, draw_quads);
    return Draw(uint(left * 6), 1u, 0u, uint(k * draw_quads * 4), 0u);
}

void main() {
    int me = int(gl_LocalInvocationIndex);
#if CHUNKS
    int count = int(chunks_in(cut_cells));
#else
    int count = group_count;
#endif
    int each = (count + THREADS - 1) / THREADS;
    int begin = min(me * each, count), end = min(begin + each, count);
    uvec2 sum = uvec2(0u);
    for (int k = begin; k < end; ++k) sum += uvec2(totals[k]);
    sums[me] = sum;
    barrier();
    for (int reach = 1; reach < THREADS; reach *= 2) {
        uvec2 before = me >= reach ? sums[me - reach] : uvec2(0u);
        barrier();
        sums[me] += before;
        barrier();
    }
    uvec2 start = sums[me] - sum, total = sums[THREADS - 1];
    for (int k = begin; k < end; ++k) {
        uvec2 own = uvec2(totals[k]);
#if CHUNKS
        totals[k] = start.x;
#else
        totals[k] = start;
#endif
        start += own;
    }
#if CHUNKS
    // Without an index buffer: the rest is no part of it
    if (me == 0) piece_draws[0] = Draw(3u * total.x, 1u, 0u, 0u, 0u);
#else
    for (int k = me; k < draws.x; k += THREADS) cell_draws[k] = draw_of(k, total.x);
    // Unless only some are selected
    for (int k = me; k < draws.y; k += THREADS) piece_draws[k] = draw_of(k, total.y * 4u);
    if (me == 0) {
        cut_cells = total.y;
        chunk_groups[0] = (chunks_in(total.y) + CHUNK_GROUP - 1u) / CHUNK_GROUP;
        chunk_groups[1] = chunk_groups[2] = 1u;
    }
#endif
}
