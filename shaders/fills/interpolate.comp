// One 3x3 pass: an empty pixel with at least `minimum_count` covered neighbours takes their median,
// channel by channel.
// In: shown colour after the warp. Out: shown colour; pixels with too few covered neighbours stay
// empty (coverage 0).
// Source: the interpolation step of the 2014 thesis this project starts from.
#define ROWS 4 // eight would spill registers
#include "lib/rows.glsl"
#include "lib/neighbour_median.glsl"
layout(rgba16f) writeonly uniform image2D filled;
uniform ivec2 shown_size;

void main() {
    ivec2 p = first_pixel();
    if (p.x >= shown_size.x) return;
    Row below = row_at(p - ivec2(0, 1)), beside = row_at(p);
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= shown_size.y) break;
        Row above = row_at(p + ivec2(0, 1));
        imageStore(filled, p, beside.middle.a > 0.0 ? beside.middle : interpolated(below, beside, above));
        below = beside;
        beside = above;
    }
}
