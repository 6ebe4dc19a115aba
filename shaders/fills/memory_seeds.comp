// The nearest inverse depth of each 2 x 2 pixels: a quarter of the points to scatter for first
// guesses.
// In: inverse depth. Out: the same in half the size, -1 where all four are unknown.
// Source: Lee et al. 2018, Iterative Depth Warping (guesses at a lower resolution); as
// warps/iterative_seed.comp, of each block its nearest.
#define ROWS 4
#include "lib/rows.glsl"
layout(r32f) readonly uniform image2D depth;
layout(r32f) writeonly uniform image2D nearest;
uniform ivec2 depth_size;

float at(ivec2 p) {
    float found = imageLoad(depth, min(p, depth_size - 1)).r;
    return found >= 0.0 && found < 1e30 ? found : -1.0;
}

void main() {
    ivec2 cell = first_pixel(), size = depth_size;
    if (2 * cell.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, ++cell.y) {
        if (2 * cell.y >= size.y) break;
        ivec2 p = 2 * cell;
        float low = max(at(p), at(p + ivec2(1, 0))), high = max(at(p + ivec2(0, 1)), at(p + ivec2(1, 1)));
        imageStore(nearest, cell, vec4(max(low, high)));
    }
}
