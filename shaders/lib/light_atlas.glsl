// What the light atlas holds at a place of a surface: indirect light, or a factor for photons.
// Included by the scene's fragment stage.
uniform sampler2D indirect; // linear RGB
uniform float texels;       // of it for each of the scene's light atlas, on both axes

// By hand: samplers blend with 8 bits, which shows as steps in smooth light.
vec3 of_atlas(vec2 place) {
    vec2 texel = place * texels;
    vec2 low = floor(texel - 0.5), part = texel - 0.5 - low;
    ivec2 first = ivec2(low), last = textureSize(indirect, 0) - 1;
    ivec2 a = clamp(first, ivec2(0), last), b = clamp(first + 1, ivec2(0), last);
    vec3 below = mix(texelFetch(indirect, a, 0).rgb, texelFetch(indirect, ivec2(b.x, a.y), 0).rgb, part.x);
    vec3 above = mix(texelFetch(indirect, ivec2(a.x, b.y), 0).rgb, texelFetch(indirect, b, 0).rgb, part.x);
    return mix(below, above, part.y);
}
