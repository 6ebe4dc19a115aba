// Gathers each shown pixel through a homography: the late picture as if everything were infinitely far.
// In: shown pixel. Out: rendered pixel by H (here shown -> rendered). A ray that left the rendered view is coverage 0.
// Source: van Waveren 2016, The Asynchronous Time Warp for Virtual Reality on Consumer Hardware.
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
layout(rgba16f) writeonly uniform image2D shown_colour;
uniform ivec2 shown_size;

vec4 gathered(vec3 q) {
    vec2 p = q.xy / q.z;
    vec4 colour = covered_average(p);
    return q.z > 0.0 && inside(p, late_size) ? colour : vec4(0.0);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= shown_size.y) break;
        imageStore(shown_colour, first + ivec2(0, row), gathered(base + H[1] * float(row)));
    }
}
