// Write the list of moving pixels, each word of the masks at its own offset.
// In: a bit for each moving pixel, and the number of moving pixels before each word. Out: x y << 16
// of each, column by column of ROWS rows.
// Source: as motion_order.comp.
#define ROWS 32
#include "lib/rows.glsl"
uniform ivec2 rendered_size;
layout(std430, binding = 1) readonly buffer Masks { uint masks[]; };
layout(std430, binding = 2) readonly buffer Before { uint before[]; };
layout(std430, binding = 4) writeonly buffer Pixels { uint pixels[]; };

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x || first.y >= rendered_size.y) return;
    int word = (first.y / ROWS) * rendered_size.x + first.x;
    uint mask = masks[word], at = before[word];
    while (mask != 0u) {
        int row = findLSB(mask);
        mask &= mask - 1u;
        pixels[at++] = uint(first.x) | uint(first.y + row) << 16u;
    }
}
