// The picture on the screen, scaled bilinearly into its viewport, with a notice on a dark
// background over it.
// In: linear light with coverage in alpha; the notice's ink. Out: sRGB, or linear light where
// GL_FRAMEBUFFER_SRGB encodes it; alpha 1.
// Source: as of lib/srgb.glsl.
#if ENCODES
#include "lib/srgb.glsl"
#endif
uniform sampler2D picture;
uniform ivec2 picture_size;
uniform ivec4 place; // x, y, width, height in pixels of the framebuffer
// Defines instead of uniforms: llvmpipe runs both sides of a branch.
#if NOTICED
uniform sampler2D ink; // 1 inside letters, or the light of a picture on it
// (x, y, 1) in pixels of the viewport to the notice's uv, homogeneous; positive in front of the eye
uniform mat3 uv_from_pixel;
#endif

out vec4 colour;

const float GROUND = 0.8; // the share of light that the background removes
const vec3 GROUND_LIGHT = vec3(0.01);

// Test with isnan alone: Mesa turns `light > 0 ? min(light, 1) : 0` into a min and a max, which
// make 1 of NaN.
vec3 light_at(ivec2 texel) {
    vec4 light = texelFetch(picture, clamp(texel, ivec2(0), picture_size - 1), 0);
    return light.a > 0.0 ? mix(clamp(light.rgb, 0.0, 1.0), vec3(0.0), isnan(light.rgb)) : vec3(0.0);
}

vec3 picture_at(vec2 p) {
#if !SCALED
    return light_at(ivec2(p));
#else
    vec2 in_picture = p * (vec2(picture_size) / vec2(place.zw)) - 0.5;
    vec2 part = fract(in_picture);
    ivec2 first = ivec2(floor(in_picture));
    vec3 lower = mix(light_at(first), light_at(first + ivec2(1, 0)), part.x);
    vec3 upper = mix(light_at(first + ivec2(0, 1)), light_at(first + ivec2(1, 1)), part.x);
    return mix(lower, upper, part.y);
#endif
}

#if NOTICED
vec3 with_notice(vec3 light, vec2 p) {
    vec3 on_notice = uv_from_pixel * vec3(p, 1.0);
    vec2 uv = on_notice.xy / on_notice.z;
    vec3 letter = texture(ink, uv).rgb; // outside every branch, for its derivatives
    bool inside = on_notice.z > 0.0 && all(greaterThanEqual(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)));
    return inside ? mix(mix(light, GROUND_LIGHT, GROUND), vec3(1.0), letter) : light;
}
#endif

void main() {
    vec2 p = gl_FragCoord.xy - vec2(place.xy);
    vec3 light = picture_at(p);
#if NOTICED
    light = with_notice(light, p);
#endif
#if ENCODES
    light = encoded_of(light);
#endif
    colour = vec4(light, 1.0);
}
