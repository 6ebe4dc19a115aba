// Gathers each shown pixel through the plane z = -1/r of the rendered eye, r the median inverse depth of the late picture.
// In: shown pixel. Out: rendered pixel q (1 + r a) - r g q_z with q = H p: the inverse of (homography + r * parallax) by the
// Sherman-Morrison formula, so that r never leaves the GPU.
// Source: docs/conventions.md; the mode "planar from depth" of XR_MSFT_composition_layer_reprojection.
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
layout(rgba16f) writeonly uniform image2D shown_colour;
uniform ivec2 shown_size;
layout(std430, binding = 0) readonly buffer Plane { float plane_inverse_depth; };

vec4 gathered(vec3 q, float r) {
    float past = 1.0 + r * e.z; // < 0 once the shown eye has moved through the plane
    vec3 s = q * past - r * q.z * e;
    vec2 p = s.xy / s.z;
    vec4 colour = covered_average(p);
    return q.z * past > 0.0 && inside(p, late_size) ? colour : vec4(0.0);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    float r = plane_inverse_depth;
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= shown_size.y) break;
        imageStore(shown_colour, first + ivec2(0, row), gathered(base + H[1] * float(row), r));
    }
}
