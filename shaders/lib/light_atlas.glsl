// Indirect light from the light atlas of the surfaces. Included by the scene's fragment stage.
// Source: as hmdwarp/scenes/radiosity.py.
uniform sampler2D indirect; // linear RGB

// By hand: samplers blend with 8 bits, which shows as steps in smooth light.
vec3 atlas_light(vec2 texel) {
    vec2 low = floor(texel - 0.5), part = texel - 0.5 - low;
    ivec2 first = ivec2(low), last = textureSize(indirect, 0) - 1;
    ivec2 a = clamp(first, ivec2(0), last), b = clamp(first + 1, ivec2(0), last);
    vec3 below = mix(texelFetch(indirect, a, 0).rgb, texelFetch(indirect, ivec2(b.x, a.y), 0).rgb, part.x);
    vec3 above = mix(texelFetch(indirect, ivec2(a.x, b.y), 0).rgb, texelFetch(indirect, b, 0).rgb, part.x);
    return mix(below, above, part.y);
}
