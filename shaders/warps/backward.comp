// Gathers each shown pixel from the late picture through the client's own depth; a depth test keeps what was hidden empty.
// In: shown pixel and the client's inverse depth there. Out: rendered pixel by H, e (here shown -> rendered) and what it held.
// Source: the reverse of McMillan and Bishop's map; depth test as in shadow mapping (Williams 1978), per texel of the footprint.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
layout(r32f) readonly uniform image2D late_inverse_depth;
layout(r32f) readonly uniform image2D client_inverse_depth;
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

float allowed, allowed_floor;
void take_limits() {
    allowed = depth_tolerance;
    allowed_floor = depth_tolerance * depth_floor;
}
#define PREPARE take_limits
#include OUTPUT

bool holds(float held, float expected) {
    return abs(held - expected) <= allowed * expected + allowed_floor;
}

// Two texels decide: the nearest, and the one across the corner of the bilinear footprint, which an edge through the footprint
// almost always parts from it. Both hold the expected depth: bilinear. One does: that one alone, so that no surface bleeds into
// another. (Asking all four would cost llvmpipe half as much time again.)
vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    float own = imageLoad(client_inverse_depth, ivec2(shown)).r;
    vec3 q = base + parallax * own;
    float depth_ratio = 1.0 / q.z;
    vec2 p = q.xy * depth_ratio;
    float expected = own * depth_ratio;
    ivec2 nearest = ivec2(p);
    vec2 centre = vec2(nearest) + 0.5;
    vec2 across = centre + mix(vec2(1.0), vec2(-1.0), lessThan(p, centre));
    bool near_holds = holds(imageLoad(late_inverse_depth, nearest).r, expected);
    bool opposite_holds = holds(imageLoad(late_inverse_depth, ivec2(floor(across))).r, expected);
    opposite_holds = opposite_holds && in_late(across); // beyond the border an image reads 0, which would pass for sky
    vec2 at = near_holds ? (opposite_holds ? p : centre) : across;
    vec4 sum = look(at);
    bool seen = (near_holds || opposite_holds) && own >= 0.0 && q.z > 0.0 && in_late(p);
    return seen ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
