// Write the lists to draw: cells with their size, and cut cells with their joined edges, each block
// at its own offset.
// In: Blocks, and the offset of each group. Out: cell x y << 16 and its width height << 16; of cut
// cells x y << 14 edges << 28.
// Source: as mesh_merge.comp.
#include "warps/mesh_surface.glsl"
#define GROUP_X 64
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) readonly buffer Blocks { Block blocks[]; };
layout(std430, binding = 1) readonly buffer Groups { uvec2 before[]; };
layout(std430, binding = 4) writeonly buffer Cells { uvec2 cells[]; };
layout(std430, binding = 5) writeonly buffer Pieces { uint pieces[]; };

uvec2 entry(ivec2 cell, uvec2 size) { return uvec2(uint(cell.x) | uint(cell.y) << 16u, size.x | size.y << 16u); }

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy), count = groups() * (GROUP / BLOCK);
    if (place.x >= count.x || place.y >= count.y) return;
    Block block = blocks[block_index(place)];
    uvec2 at = before[group_index(place / (GROUP / BLOCK))] + uvec2(block.error_order & 1023u, block.error_order >> 10u & 1023u);
    uint level = block.error_order >> 20u;
    ivec2 first = first_cell(place);
    if (level >= 1u && level <= 3u) cells[at.x] = entry(first, uvec2(2u << level));
    uint begins = level == 0u ? block.cells & 0xFFFFu : 0u, cut = block.cells >> 16u;
    for (int k = 0; k < 16; ++k) {
        ivec2 cell = ivec2(k & 3, k >> 2);
        uint size = (k < 8 ? block.sizes_low : block.sizes_high) >> uint((k & 7) * 4);
        if ((begins >> uint(k) & 1u) != 0u) cells[at.x++] = entry(first + cell, uvec2(size & 3u, size >> 2u & 3u) + 1u);
        if ((cut >> uint(k) & 1u) == 0u) continue;
        uint rows = block.rows >> uint(k), columns = block.columns >> uint(cell.y * 5 + cell.x);
        uint edges = (rows & 1u) | (rows >> 4u & 1u) << 1u | (columns & 1u) << 2u | (columns >> 1u & 1u) << 3u;
        pieces[at.y++] = uint(first.x + cell.x) | uint(first.y + cell.y) << 14u | edges << 28u;
    }
}
