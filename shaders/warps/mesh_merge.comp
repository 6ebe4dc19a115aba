// Decide for each group of 4x4 blocks which merge into one cell, and count the group's draws.
// In: Blocks. Out: their level and their order in the group; the group's numbers of whole and of
// cut cells.
// Source: Schollmeyer et al. 2017, Efficient Hybrid Image Warping for High Frame-Rate Stereoscopic
// Rendering (a quadtree over depth).
#include "warps/mesh_surface.glsl"
#include "warps/mesh_flatness.glsl"
#define GROUP_X 64
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) buffer Blocks { Block blocks[]; };
layout(std430, binding = 1) writeonly buffer Groups { uvec2 totals[]; };

// Levels; covered: by another block's cell, or off screen
const uint OWN = 0u, FOUR = 1u, EIGHT = 2u, SIXTEEN = 3u, COVERED = 4u;

void main() {
    ivec2 group = ivec2(gl_GlobalInvocationID.xy), count = groups();
    if (group.x >= count.x || group.y >= count.y) return;
    ivec2 first = group * (GROUP / BLOCK);
    uint level[16];
    for (int k = 0; k < 16; ++k) level[k] = OWN;
#if ADAPTIVE
    ivec2 pixel = first_cell(first) - 1;
    float r[25];
    for (int k = 0; k < 25; ++k) r[k] = known_inverse_depth(pixel + BLOCK * ivec2(k % 5, k / 5));
    float quarters = 0.0;
    for (int q = 0; q < 4; ++q) {
        int corner = (q >> 1) * 8 + (q & 1) * 2;
        float worst = 0.0;
        for (int k = 0; k < 4; ++k) {
            int b = corner + (k >> 1) * 4 + (k & 1);
            ivec2 at = ivec2(b & 3, b >> 2);
            int p = at.y * 5 + at.x;
            float error = uintBitsToFloat(blocks[block_index(first + at)].error_order);
            worst = max(worst, error);
            if (coarsest >= 4 && error <= allowed_error(pixel + BLOCK * at, BLOCK, r[p], r[p + 1], r[p + 5], r[p + 6])) {
                level[b] = blocks[block_index(first + at)].rows >> 31u != 0u ? FOUR : COVERED;
            }
        }
        int p = (q >> 1) * 10 + (q & 1) * 2;
        float error = worst + unevenness(r[p], r[p + 1], r[p + 2], r[p + 5], r[p + 6], r[p + 7], r[p + 10], r[p + 11], r[p + 12]);
        quarters = max(quarters, error);
        ivec2 at = 2 * BLOCK * ivec2(q & 1, q >> 1);
        if (coarsest >= 8 && error <= allowed_error(pixel + at, 2 * BLOCK, r[p], r[p + 2], r[p + 10], r[p + 12])) {
            level[corner + 1] = level[corner + 4] = level[corner + 5] = COVERED;
            level[corner] = EIGHT;
        }
    }
    float error = quarters + unevenness(r[0], r[2], r[4], r[10], r[12], r[14], r[20], r[22], r[24]);
    if (coarsest >= 16 && error <= allowed_error(pixel, GROUP, r[0], r[4], r[20], r[24])) {
        for (int k = 1; k < 16; ++k) level[k] = COVERED;
        level[0] = SIXTEEN;
    }
#endif
    uint cells = 0u, pieces = 0u;
    for (int k = 0; k < 16; ++k) {
        int index = block_index(first + ivec2(k & 3, k >> 2));
        blocks[index].error_order = level[k] << 20u | pieces << 10u | cells;
        cells += level[k] == OWN ? uint(bitCount(blocks[index].cells & 0xFFFFu)) : uint(level[k] != COVERED);
        pieces += uint(bitCount(blocks[index].cells >> 16u));
    }
    totals[group_index(group)] = uvec2(cells, pieces);
}
