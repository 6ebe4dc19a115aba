// One transparent sheet, for blending over what lies behind it; or, with COLOUR 0, its depth.
// In: uv and linear light of the sheet; inverse depth of the picture. Out: the sheet's own light,
// premultiplied, and beside it the share of the light behind that passes, by colour (the second
// source of the blending); or inverse depth in 1/m.
// Source: Porter and Duff 1984, Compositing Digital Images (over); OpenGL 4.3 specification, 17.3.8
// (dual-source blending).
//
// TESTS 0: all sheets. 1: sheets that the picture does not occlude. 2: those and, in pixels where
// it occludes all, the occluded ones, for when a moving head uncovers them.
in vec2 uv;
in vec3 light;

uniform sampler2D surface;
uniform float opacity;
uniform vec3 tint; // transmission of the sheet, by colour, where its texture does not block the light
#if TESTS
uniform sampler2D picture; // its inverse depth
uniform float keep;        // a little below 1: a sheet that lies on a surface is not occluded by it
#endif
#if TESTS == 2
uniform sampler2D unhidden; // inverse depth of the nearest visible sheet, -1: none
#endif
#if COLOUR
uniform float covers; // 1: alpha is coverage, whatever the transmission; 0: the share of light that does not pass

layout(location = 0, index = 0) out vec4 veil;
layout(location = 0, index = 1) out vec4 passing;
#else
layout(location = 0) out float inverse_depth;
#endif

const float LEAST = 1.0 / 256.0; // below this a sheet is absent: mipmaps spread traces of everything everywhere

void main() {
    // Before a discard: after it the neighbours' uv, and so the mip level, would be undefined
    vec4 texel = texture(surface, uv);
    float share = opacity * texel.a;
    if (share < LEAST && min(min(tint.r, tint.g), tint.b) > 1.0 - LEAST) discard;
#if TESTS
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    bool may_be_hidden = true;
#if TESTS == 2
    may_be_hidden = texelFetch(unhidden, pixel, 0).r >= 0.0;
#endif
    if (may_be_hidden && gl_FragCoord.w < texelFetch(picture, pixel, 0).r * keep) discard;
#endif
#if COLOUR
    veil = vec4(texel.rgb * light * share, max(share, covers));
    passing = vec4(tint * (1.0 - share), 1.0 - share);
#else
    inverse_depth = gl_FragCoord.w;
#endif
}
