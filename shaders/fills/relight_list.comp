// List the holes of a picture. Where they are cracks, any eight neighbours contain one, and a loop
// over samples would run for all eight.
// In: the shown picture with holes. Out: their number and places, in any order.
// Source: this project's; six times as fast as visiting all pixels after warp `forward` (15 %
// holes) on llvmpipe.
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D warped;
layout(std430, binding = 2) buffer Holes { uint hole_count, none_a, none_b, none_c; uint hole_at[]; };
uniform ivec2 shown_size;

void main() {
    ivec2 p = first_pixel();
    if (p.x >= shown_size.x) return;
    uint holes = 0u;
    for (int row = 0; row < ROWS; ++row)
        if (p.y + row < shown_size.y && imageLoad(warped, p + ivec2(0, row)).a == 0.0) holes |= 1u << row;
    if (holes == 0u) return;
    uint next = atomicAdd(hole_count, uint(bitCount(holes)));
    for (int row = 0; row < ROWS; ++row)
        if ((holes & (1u << row)) != 0u) hole_at[next++] = uint(p.x) | uint(p.y + row) << 16;
}
