// Runs a gather warp's `gathered` for every pixel of the shown view.
// shown: the pixel's centre. base + parallax * inverse_depth: the rendered pixel (homogeneous) of a point at that depth from here.
#include "lib/rows.glsl"
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 shown_size;
vec4 gathered(vec2 shown, vec3 base, vec3 parallax);

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    vec2 start = vec2(first) + 0.5;
    vec3 base = H * vec3(start, 1.0);
#ifdef SCANOUT
    vec3 base_linear = H_linear * vec3(start, 1.0), base_square = H_square * vec3(start, 1.0);
#endif
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= shown_size.y) break;
        vec2 shown = start + vec2(0.0, float(row));
        vec3 here = base + H[1] * float(row);
#ifdef SCANOUT
        float t = 1.0 - shown.y / float(shown_size.y);
        here += t * (base_linear + H_linear[1] * float(row) + t * (base_square + H_square[1] * float(row)));
        vec3 parallax = e + t * (e_linear + t * e_square);
#else
        vec3 parallax = e;
#endif
        imageStore(written, first + ivec2(0, row), gathered(shown, here, parallax));
    }
}
