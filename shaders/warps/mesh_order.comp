// Turns what each group draws into where it begins in the lists, and writes the draw calls. One work group.
// In: numbers of cells and of cells in pieces. Out: their sums over all groups before; indirect draws of DRAW quads each.
// Source: Hillis and Steele 1986, Data Parallel Algorithms (the scan); a fixed order makes two runs equal to the last bit.
#define THREADS 256
layout(local_size_x = THREADS) in;
struct Draw { uint count, instances, first, base_vertex, base_instance; };
layout(std430, binding = 1) buffer Groups { uvec2 drawn[]; };
layout(std430, binding = 2) writeonly buffer CellDraws { Draw cell_draws[]; };
layout(std430, binding = 3) writeonly buffer PieceDraws { Draw piece_draws[]; };
uniform int group_count;
uniform ivec2 draws;     // that there is room for: of cells, of pieces
uniform int draw_quads;  // quads in one draw
shared uvec2 sums[THREADS];

Draw draw_of(int k, uint quads) {
    int left = clamp(int(quads) - k * draw_quads, 0, draw_quads);
    return Draw(uint(left * 6), 1u, 0u, uint(k * draw_quads * 4), 0u);
}

void main() {
    int me = int(gl_LocalInvocationIndex);
    int each = (group_count + THREADS - 1) / THREADS;
    int begin = min(me * each, group_count), end = min(begin + each, group_count);
    uvec2 sum = uvec2(0u);
    for (int k = begin; k < end; ++k) sum += drawn[k];
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
        uvec2 own = drawn[k];
        drawn[k] = start;
        start += own;
    }
    for (int k = me; k < draws.x; k += THREADS) cell_draws[k] = draw_of(k, total.x);
    for (int k = me; k < draws.y; k += THREADS) piece_draws[k] = draw_of(k, total.y * 4u);
}
