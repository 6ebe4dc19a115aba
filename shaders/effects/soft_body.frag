// What deforms without its light, but with what it emits; with LATE also under its baked light, and where the late picture
// had the same place of the surface.
// In: uv, albedo, baked colour; metres along the axes of the late picture's eye. Out: albedo with
// coverage 1, inverse depth; baked colour; the place, and the surface's normal there, away from the
// side that is seen now.
// Source: Nehab et al. 2007, Accelerating Real-Time Shading with Reverse Reprojection Caching.
#include "lib/emission.glsl"

uniform sampler2D surface;

in vec2 uv;
in vec3 light;
layout(location = 0) out vec4 albedo;
layout(location = 1) out float inverse_depth;
#if LATE
in vec3 place;
in vec3 baked;
layout(location = 2) out vec4 lit;
layout(location = 3) out vec4 late_place;
layout(location = 4) out vec4 late_normal;
#endif

void main() {
    vec3 texel = texture(surface, uv).rgb;
    vec3 shining = emitted(uv);
    albedo = vec4(texel * light + shining, 1.0);
    inverse_depth = gl_FragCoord.w;
#if LATE
    lit = vec4(texel * baked + shining, 1.0);
    late_place = vec4(place, 1.0);
    vec3 away = cross(dFdy(place), dFdx(place));
    late_normal = vec4(away / max(length(away), 1e-20), 0.0);
#endif
}
