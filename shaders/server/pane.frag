// One transparent sheet, for blending over what lies behind it; or, with COLOUR 0, its depth, of
// which the blending keeps the maximum.
// In: uv and linear light of the sheet; inverse depth of the picture. Out: the sheet's own light,
// premultiplied, and beside it the share of the light behind that passes, by colour (the second
// source of the blending); or inverse depth in 1/m, -1 if the picture occludes it, and again
// without that test.
// Source: Porter and Duff 1984, Compositing Digital Images (over); OpenGL 4.3 specification, 17.3.8
// (dual-source blending).
//
// TESTS 0: all sheets. 1: sheets that the picture does not occlude. 2: those and, in pixels where
// it occludes all, the occluded ones, for when a moving head uncovers them.
#include "lib/sheet.glsl"
in vec3 light;    // that it scatters itself
in vec3 coloured; // share of the light behind that passes where it covers, by colour, its texture apart

#if TESTS
uniform sampler2D picture; // its inverse depth
uniform float keep;        // a little below 1: a sheet that lies on a surface is not occluded by it
#endif
#if TESTS == 2
uniform sampler2D nearest; // of COLOUR 0: inverse depth of the nearest visible sheet, -1: none
#endif
#if COLOUR
uniform float covers; // 1: alpha is coverage, whatever the transmission; 0: the share of light that does not pass

layout(location = 0, index = 0) out vec4 veil;
layout(location = 0, index = 1) out vec4 passing;
#else
layout(location = 0) out vec2 depths;
#endif

const float LEAST = 1.0 / 256.0; // below this a sheet is absent: mipmaps spread traces of everything everywhere

void main() {
    vec4 texel = sheet_texel();
    float share = passes.a * texel.a;
    vec3 through = passes.rgb * (1.0 - share) + coloured * texel.rgb * share;
    bool is_there = min(min(through.r, through.g), through.b) <= 1.0 - LEAST;
    if (!is_there || !is_drawn()) discard;
#if TESTS
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    bool is_occluded = gl_FragCoord.w < texelFetch(picture, pixel, 0).r * keep;
#if TESTS == 2
    is_occluded = is_occluded && texelFetch(nearest, pixel, 0).r >= 0.0;
#endif
#endif
#if TESTS && COLOUR
    if (is_occluded) discard;
#endif
#if COLOUR
    veil = vec4(texel.rgb * light * share, max(share, covers));
    passing = vec4(through, 1.0 - share);
#else
    depths = vec2(is_occluded ? -1.0 : gl_FragCoord.w, gl_FragCoord.w);
#endif
}
