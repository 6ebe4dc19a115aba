// Indirect light of a pixel from a picture of half the size: the mean of what was gathered around it
// on the same surface. Where nothing was, cones look from the pixel itself.
// Source: Kopf et al. 2007, Joint Bilateral Upsampling.
#include "lib/voxels.glsl"
uniform sampler2D near_light_of;  // linear RGB
uniform sampler2D near_place_of;  // metres from the scene's origin, 1 where lamps light it
uniform sampler2D near_normal_of;
uniform vec2 corner;     // first pixel of this view in the picture
uniform vec2 near_scale; // pixels of the small picture for each of this

const float SAME_PLANE = 0.5; // cells that a neighbour may lie before or behind this surface
const float ENOUGH = 0.1;     // of all weight

vec3 near_light(vec3 place, vec3 normal) {
    vec2 at = (gl_FragCoord.xy - corner) * near_scale - 0.5, low = floor(at), part = at - low;
    ivec2 last = textureSize(near_light_of, 0) - 1;
    vec4 total = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1), p = clamp(ivec2(low) + step, ivec2(0), last);
        vec4 there = texelFetch(near_place_of, p, 0);
        float apart = abs(dot(there.xyz - place, normal)) / (SAME_PLANE * cell_m);
        float alike = max(0.0, dot(texelFetch(near_normal_of, p, 0).xyz, normal));
        vec2 share = mix(1.0 - part, part, vec2(step));
        float weight = there.w * share.x * share.y * max(0.0, 1.0 - apart) * alike * alike * alike * alike;
        total += weight * vec4(texelFetch(near_light_of, p, 0).rgb, 1.0);
    }
    return total.w > ENOUGH ? total.rgb / total.w : voxel_light(place, normal);
}
