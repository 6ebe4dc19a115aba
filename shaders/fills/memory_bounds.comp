// Bounds of depth and colour in the newest picture around each place, in cells of 2 x 2 pixels with
// a border of one pixel.
// In: rendered colour and inverse depth. Out: (nearest, farthest) inverse depth, lowest and highest
// colour; nearest is infinite where any of the 16 pixels is unknown, so that they disprove nothing.
// Source: min-max mipmaps as in Tevs et al. 2008, Maximum Mipmaps for Fast, Accurate, and Scalable
// Dynamic Height Field Rendering.
#define ROWS 4
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(r32f) readonly uniform image2D rendered_depth;
layout(rg32f) writeonly uniform image2D depths;
layout(rgba16f) writeonly uniform image2D lowest;
layout(rgba16f) writeonly uniform image2D highest;
uniform ivec2 rendered_size;

const float UNKNOWN = 1e30;

// Of four pixels of a row: nearest and farthest inverse depth, lowest and highest colour.
struct Bounds {
    vec2 range;
    vec4 low, high;
};

Bounds row_from(ivec2 from) {
    Bounds row = Bounds(vec2(-1.0, UNKNOWN), vec4(UNKNOWN), vec4(-UNKNOWN));
    for (int x = 0; x < 4; ++x) {
        ivec2 p = clamp(from + ivec2(x, 0), ivec2(0), rendered_size - 1);
        float depth = imageLoad(rendered_depth, p).r;
        vec4 colour = imageLoad(rendered_colour, p);
        row.range.x = max(row.range.x, depth >= 0.0 ? depth : UNKNOWN); // NaN counts as unknown
        row.range.y = min(row.range.y, depth);
        row.low = min(row.low, colour);
        row.high = max(row.high, colour);
    }
    return row;
}

Bounds both(Bounds a, Bounds b) {
    return Bounds(vec2(max(a.range.x, b.range.x), min(a.range.y, b.range.y)), min(a.low, b.low), max(a.high, b.high));
}

void main() {
    ivec2 cell = first_pixel(), size = rendered_size;
    if (2 * cell.x >= size.x) return;
    // The upper half of one cell is the lower half of the next one in the column, so it is read
    // once.
    Bounds lower = both(row_from(2 * cell - 1), row_from(2 * cell + ivec2(-1, 0)));
    for (int row = 0; row < ROWS; ++row, ++cell.y) {
        if (2 * cell.y >= size.y) break;
        Bounds upper = both(row_from(2 * cell + ivec2(-1, 1)), row_from(2 * cell + ivec2(-1, 2)));
        Bounds all = both(lower, upper);
        imageStore(depths, cell, vec4(all.range, 0.0, 0.0));
        imageStore(lowest, cell, all.low);
        imageStore(highest, cell, all.high);
        lower = upper;
    }
}
