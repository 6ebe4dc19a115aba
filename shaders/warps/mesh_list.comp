// Writes the lists that are drawn: cells with their size, and cells in pieces with their joined edges, each block at its own place.
// In: Blocks, and where each group begins. Out: cell x | y << 14 | level << 28 (a side of 2^level cells), or | edges << 28.
// Source: as mesh_merge.comp.
#include "warps/mesh_surface.glsl"
#define GROUP_X 64
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) readonly buffer Blocks { Block blocks[]; };
layout(std430, binding = 1) readonly buffer Groups { uvec2 before[]; };
layout(std430, binding = 4) writeonly buffer Cells { uint cells[]; };
layout(std430, binding = 5) writeonly buffer Pieces { uint pieces[]; };

uint entry(ivec2 cell, uint four_bits) { return uint(cell.x) | uint(cell.y) << 14u | four_bits << 28u; }

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy), count = groups() * (GROUP / BLOCK);
    if (place.x >= count.x || place.y >= count.y) return;
    Block block = blocks[block_index(place)];
    uvec2 at = before[group_index(place / (GROUP / BLOCK))] + uvec2(block.error_order & 1023u, block.error_order >> 10u & 1023u);
    uint level = block.error_order >> 20u;
    ivec2 first = first_cell(place);
    if (level >= 1u && level <= 3u) cells[at.x] = entry(first, level + 1u);
    uint whole = level == 0u ? block.cells & 0xFFFFu : 0u, cut = block.cells >> 16u, flats = block.rows_flat >> 20u;
    for (int k = 0; k < 16; ++k) {
        ivec2 cell = ivec2(k & 3, k >> 2);
        uint quarter = flats >> uint((cell.y >> 1) * 2 + (cell.x >> 1)) & 1u;
        bool leads = ((cell.x | cell.y) & 1) == 0;
        if ((whole >> uint(k) & 1u) != 0u && (quarter == 0u || leads)) cells[at.x++] = entry(first + cell, quarter);
        if ((cut >> uint(k) & 1u) == 0u) continue;
        uint rows = block.rows_flat >> uint(k), columns = block.columns >> uint(cell.y * 5 + cell.x);
        uint edges = (rows & 1u) | (rows >> 4u & 1u) << 1u | (columns & 1u) << 2u | (columns >> 1u & 1u) << 3u;
        pieces[at.y++] = entry(first + cell, edges);
    }
}
