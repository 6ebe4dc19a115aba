// The surfaces of a rendered picture without known mirrors: coverage alone.
// In: rendered colour. Out: (0, 0, 0, coverage).
// Source: none.
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(rgba16f) writeonly uniform image2D surface;
uniform ivec2 rendered_size;

void main() {
    ivec2 p = first_pixel(), size = rendered_size;
    if (p.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        imageStore(surface, p, vec4(0.0, 0.0, 0.0, imageLoad(rendered_colour, p).a));
    }
}
