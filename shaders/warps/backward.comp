// Gathers each shown pixel from the rendered picture through the client's own depth; with TEST, a
// depth test leaves disocclusions empty, else they take the colour of what hid them.
// In: shown pixel and the client's inverse depth there. Out: rendered pixel by H, e (here shown ->
// rendered), and its colour.
// Source: the reverse of McMillan and Bishop's map; depth test as in shadow mapping (Williams
// 1978), per texel of the footprint.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
layout(r32f) readonly uniform image2D client_inverse_depth;
#if TEST
layout(r32f) readonly uniform image2D rendered_inverse_depth;
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

float allowed, allowed_floor;
void take_limits() {
    allowed = depth_tolerance;
    allowed_floor = depth_tolerance * depth_floor;
}
#define PREPARE take_limits
#endif
#include OUTPUT

#if TEST
bool holds(float held, float expected) {
    return abs(held - expected) <= allowed * expected + allowed_floor;
}

// The client has depth at the centres of its pixels, so the surface there decides. Two texels are
// tested: the one the centre lies in, and the one across from it in the bilinear footprint, which
// an edge through the footprint almost always separates from it. If both have the expected depth,
// the sample is bilinear; if one does, that texel alone, so that no surface bleeds into another.
// (Testing all four would take llvmpipe half as long again; testing around the place itself tore
// silhouettes behind the lens, where places are no centres.)
vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    float own = imageLoad(client_inverse_depth, ivec2(shown)).r;
#ifdef WRITES_DEPTH
    found_inverse_depth = own;
#endif
    vec3 q = base + parallax * own;
    vec2 p = q.xy / q.z;
    vec3 at_centre = base_at_centre(shown, base) + parallax * own;
    float depth_ratio = 1.0 / at_centre.z;
    float expected = own * depth_ratio;
    vec2 nearest = floor(at_centre.xy * depth_ratio);
    vec2 across = 2.0 * floor(p - 0.5) + 1.0 - nearest;
    bool near_holds = holds(imageLoad(rendered_inverse_depth, ivec2(nearest)).r, expected);
    bool across_holds = holds(imageLoad(rendered_inverse_depth, ivec2(across)).r, expected);
    near_holds = near_holds && in_rendered(nearest); // beyond the border an image reads 0, which would pass for sky
    across_holds = across_holds && in_rendered(across);
    vec2 at = near_holds ? (across_holds ? p : nearest + 0.5) : across + 0.5;
    vec4 sum = sampled(at);
    bool ahead = own >= 0.0 && q.z > 0.0 && at_centre.z > 0.0;
    return ahead && (near_holds || across_holds) && in_rendered(p) ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
#else
vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    float own = imageLoad(client_inverse_depth, ivec2(shown)).r;
#ifdef WRITES_DEPTH
    found_inverse_depth = own;
#endif
    vec3 q = base + parallax * own;
    vec2 p = q.xy / q.z;
    return own >= 0.0 && q.z > 0.0 && in_rendered(p) ? covered_average(p) : vec4(0.0);
}
#endif
