// Fills what a level of the pyramid lacks from the level above. The last one writes sRGB.
// In: colour times its weight, weight. Out: the same, whole; (ALONE) holes stay black.
// Source: Gortler et al. 1996, The Lumigraph; IEC 61966-2-1:1999.
#include "lib/srgb.glsl"
uniform sampler2D colours, above;
uniform bool is_last;
uniform ivec2 corner; // of the viewport
layout(location = 0) out vec4 whole;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy) - corner;
    vec4 own = texelFetch(colours, texel, 0);
#ifdef ALONE
    vec4 up = vec4(0.0);
#else
    vec4 up = textureLod(above, (vec2(texel) + 0.5) * 0.5 / vec2(textureSize(above, 0)), 0.0);
#endif
    whole = own + (1.0 - own.a) * (up.a > 0.0 ? vec4(up.rgb / up.a, 1.0) : vec4(0.0));
    if (is_last) whole = vec4(encoded_of(clamp(whole.rgb / max(whole.a, 1e-6), 0.0, 1.0)), 1.0);
}
