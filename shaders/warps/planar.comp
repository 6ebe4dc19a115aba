// Gathers each shown pixel through the plane z = -1/r of the rendered eye, r the median inverse
// depth of the rendered picture.
// In: shown pixel. Out: rendered pixel: a point of that plane has s = r b_z / (1 - r e_z) in the
// shown view, so q = b + e s, and q_xy / q_z = (1 - r e_z) b_xy / b_z + r e_xy; r never leaves the
// GPU.
// Source: docs/conventions.md; the mode "planar from depth" of
// XR_MSFT_composition_layer_reprojection.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include "lib/depth_beside.glsl"
layout(std430, binding = 0) readonly buffer Plane { float plane_inverse_depth; };
float plane;
void take_plane() { plane = plane_inverse_depth; }
#define PREPARE take_plane
#include OUTPUT

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    float past = 1.0 - plane * parallax.z; // < 0 once the shown eye has passed through the plane
    vec2 p = base.xy / base.z * past + plane * parallax.xy;
    vec4 colour = covered_average(p);
#ifdef WRITES_DEPTH
    found_inverse_depth = shown_depth_of(p);
#endif
    return base.z * past > 0.0 && in_rendered(p) ? colour : vec4(0.0);
}
