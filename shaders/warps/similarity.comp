// Gathers each shown pixel through one shift, rotation and scale: those of the plane z = -1/r of
// the rendered eye (r the median inverse depth) around the middle of the shown view.
// In: shown pixel x. Out: rendered pixel p(m) + A (x - m), m the middle, p the planar map (see
// planar.comp). In tangents A is the conformal part of p's Jacobian J at m: of all a + ib the one
// with the least sum of squares |J d - (a + ib) d|^2 over all directions d.
// Source: docs/conventions.md for the map; the conformal part of a 2x2 matrix is its orthogonal
// projection (Frobenius) onto rotations times scales.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include "lib/depth_beside.glsl"
layout(std430, binding = 0) readonly buffer Plane { float plane_inverse_depth; };
uniform vec2 middle, shown_per_tangent, rendered_per_tangent;
vec2 from, to;
mat2 around;
bool ahead;

void take_similarity() {
    from = middle;
    vec3 base = H * vec3(middle, 1.0);
    float past = 1.0 - plane_inverse_depth * e.z;
    vec2 far = base.xy / base.z;
    ahead = base.z * past > 0.0;
    to = far * past + plane_inverse_depth * e.xy;
    vec2 by_x = (H[0].xy - far * H[0].z) * (past / base.z), by_y = (H[1].xy - far * H[1].z) * (past / base.z);
    // Per pixel to per tangent, and back for each axis.
    vec2 x = by_x * shown_per_tangent.x / rendered_per_tangent, y = by_y * shown_per_tangent.y / rendered_per_tangent;
    vec2 turn = 0.5 * vec2(x.x + y.y, x.y - y.x);
    around = mat2(turn * rendered_per_tangent / shown_per_tangent.x,
                  vec2(-turn.y, turn.x) * rendered_per_tangent / shown_per_tangent.y);
}
#define PREPARE take_similarity
#include OUTPUT

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    vec2 p = to + around * (shown - from);
    vec4 colour = covered_average(p);
#ifdef WRITES_DEPTH
    found_inverse_depth = shown_depth_of(p);
#endif
    return ahead && in_rendered(p) ? colour : vec4(0.0);
}
