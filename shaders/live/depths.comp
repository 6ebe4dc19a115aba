// Samples a picture on a grid, at the middle of each cell.
// In: inverse depth in 1/m, whole pixels. Out: depths[], row by row from the bottom, slot after slot.
// Source: none; the nearest pixel.
#include "lib/rows.glsl"
layout(std430, binding = 0) writeonly buffer Depths { float depths[]; };
layout(r32f) readonly uniform image2D inverse_depth;
uniform ivec2 size;
uniform int points;
uniform int slot;

void main() {
    ivec2 p = first_pixel();
    if (p.x >= points) return;
    for (int row = 0; row < ROWS && p.y < points; ++row, ++p.y) {
        depths[(slot * points + p.y) * points + p.x] = imageLoad(inverse_depth, (2 * p + 1) * size / (2 * points)).r;
    }
}
