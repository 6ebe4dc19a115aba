// Separate what mirrors show from the surfaces' own light: a surface looks different from another
// eye by what that eye sees in it instead, so light here = light there + what differs. START begins
// with no light; each further run follows the rays through one more picture.
// In: the aligned pictures, places in them, the light so far. Out: light that mirrors show, up to a constant; alpha
// 1 where there is a mirror image.
// Source: Szeliski et al. 2000, Layer Extraction from Multiple Images Containing Reflections and
// Transparency (alternating estimates of two layers), here by differences, so that the surface's own
// light drops out.
#include "lib/rows.glsl"
#define IMAGES
#include "effects/mirrored.glsl"
layout(rgba16f) writeonly uniform image2D written;
#ifndef START
uniform sampler2DArray aligned;
uniform sampler2D light_before;
uniform vec2 rendered_pixel; // 1 / rendered_size
uniform int pictures;
layout(rg32f, binding = 1) readonly uniform image2DArray given; // places of mirrored_places.comp
// Towards no light at all, as part of a picture: where few pictures tell, what the rays do not decide
// stays with the surface instead of piling up along them.
const float PULL = 0.3;
#endif

vec4 light_at(ivec2 pixel) {
#ifdef START
    return vec4(0.0, 0.0, 0.0, float(mirrors_at(vec2(pixel) + 0.5)));
#else
    vec4 before = texelFetch(light_before, pixel, 0);
    if (before.a < 0.5) return vec4(0.0);
    vec4 here = texelFetch(aligned, ivec3(pixel, 0), 0), sum = vec4(0.0);
    for (int k = 1; k < pictures; ++k) {
        vec4 there = texelFetch(aligned, ivec3(pixel, k), 0);
        vec2 place = imageLoad(given, ivec3(pixel, k)).rg;
        vec4 seen = textureLod(light_before, place * rendered_pixel, 0.0);
        bool counts = min(here.a, there.a) > 0.5 && place.x >= 0.0 && seen.a >= 0.5;
        sum += counts ? vec4(here.rgb - there.rgb + seen.rgb / seen.a, 1.0) : vec4(0.0);
    }
    return sum.a > 0.0 ? vec4(sum.rgb / (sum.a + PULL), 1.0) : before;
#endif
}

void main() {
    ivec2 p = first_pixel();
    if (p.x >= rendered_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= rendered_size.y) break;
        imageStore(written, p, light_at(p));
    }
}
