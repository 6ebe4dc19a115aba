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

void main() {
    ivec2 cell = first_pixel(), size = rendered_size;
    if (2 * cell.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, ++cell.y) {
        if (2 * cell.y >= size.y) break;
        vec2 range = vec2(-1.0, UNKNOWN);
        vec4 low = vec4(UNKNOWN), high = vec4(-UNKNOWN);
        for (int y = -1; y <= 2; ++y)
            for (int x = -1; x <= 2; ++x) {
                ivec2 p = clamp(2 * cell + ivec2(x, y), ivec2(0), size - 1);
                float depth = imageLoad(rendered_depth, p).r;
                vec4 colour = imageLoad(rendered_colour, p);
                range.x = max(range.x, depth >= 0.0 ? depth : UNKNOWN); // NaN counts as unknown
                range.y = min(range.y, depth);
                low = min(low, colour);
                high = max(high, colour);
            }
        imageStore(depths, cell, vec4(range, 0.0, 0.0));
        imageStore(lowest, cell, low);
        imageStore(highest, cell, high);
    }
}
