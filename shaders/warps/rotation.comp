// Gathers each shown pixel through a homography: the rendered picture as if everything were
// infinitely far.
// In: shown pixel. Out: rendered pixel by H (here shown -> rendered). A ray that left the rendered
// view is coverage 0, or (CLAMP) has the colour of the nearest border pixel.
// Source: van Waveren 2016, The Asynchronous Time Warp for Virtual Reality on Consumer Hardware.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include "lib/depth_beside.glsl"
#include OUTPUT

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    vec2 p = base.xy / base.z;
#if CLAMP
    p = clamp(p, vec2(0.5), rendered_extent - 0.5);
#endif
    vec4 colour = covered_average(p);
#ifdef WRITES_DEPTH
    found_inverse_depth = shown_depth_of(p);
#endif
    return base.z > 0.0 && in_rendered(p) ? colour : vec4(0.0);
}
