// Indirect light of a pixel from splatted light at low resolution: bilateral upsampling, by place
// and normal. Included by the scene's fragment stage.
// Source: Kopf et al. 2007, Joint Bilateral Upsampling.
#include "lib/receivers.glsl"
uniform sampler2D splatted; // light, linear RGB
uniform vec2 low_per_pixel;

// Radii off the pixel's plane at which a low pixel counts half, and what it counts in any case.
const float HALF_OFF = 0.05;
const float LEAST_WEIGHT = 1e-6;

vec3 splatted_light(vec3 place, vec3 normal) {
    vec2 at = gl_FragCoord.xy * low_per_pixel - 0.5;
    ivec2 first = ivec2(floor(at)), last = textureSize(receivers, 0) - 1;
    vec4 total = vec4(0.0);
    for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) {
            ivec2 here = first + ivec2(x, y);
            if (any(lessThan(here, ivec2(0))) || any(greaterThan(here, last))) continue;
            float inverse_depth = texelFetch(receiver_depth, here, 0).r;
            vec4 receiver = texelFetch(receivers, here, 0);
            if (inverse_depth <= 0.0 || receiver.w <= 0.0) continue;
            vec2 away = abs(at - vec2(here));
            float tent = max(1.0 - 0.5 * away.x, 0.0) * max(1.0 - 0.5 * away.y, 0.0);
            float off = dot(receiver_place(here, inverse_depth) - place, normal) / (HALF_OFF * radius);
            float alike = step(LEAST_COSINE, dot(receiver.xyz, normal)) / (1.0 + off * off * off * off);
            total += tent * (alike + LEAST_WEIGHT) * vec4(texelFetch(splatted, here, 0).rgb, 1.0);
        }
    return total.w > 0.0 ? total.rgb / total.w : vec3(0.0);
}
