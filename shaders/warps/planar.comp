// Gathers each shown pixel through the plane z = -1/r of the rendered eye, r the median inverse depth of the late picture.
// In: shown pixel. Out: rendered pixel: a point of that plane has s = r b_z / (1 - r e_z) in the shown view, so q = b + e s, here
// times (1 - r e_z); r never leaves the GPU.
// Source: docs/conventions.md; the mode "planar from depth" of XR_MSFT_composition_layer_reprojection.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include OUTPUT
layout(std430, binding = 0) readonly buffer Plane { float plane_inverse_depth; };

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    float r = plane_inverse_depth;
    float past = 1.0 - r * parallax.z; // < 0 once the shown eye has moved through the plane
    vec3 s = base * past + r * base.z * parallax;
    vec2 p = s.xy / s.z;
    vec4 colour = covered_average(p);
    return base.z * past > 0.0 && in_late(p) ? colour : vec4(0.0);
}
