// One panel over an eye's picture, sampled once, at the newest pose; LEVEL: a mip level of it, each
// texel the mean of its part of the level below.
// In: its place in the picture; OCCLUDED: the depth of what may hide it. Out: premultiplied linear
// light to blend over; ENCODED: sRGB, and the share that it covers.
// Source: Porter and Duff 1984, Compositing Digital Images (over); lib/panel_sample.glsl.
#include "lib/srgb.glsl"
#include "lib/panel_sample.glsl"
#ifdef OCCLUDED
uniform sampler2D shown_inverse_depth;
uniform float nearer; // a little above 1: a panel that lies on a surface is not hidden by it
#endif
uniform ivec2 corner; // of the picture
uniform mat3 panel_from_shown;
out vec4 written;

#ifdef LEVEL
uniform vec2 level_texels;

void main() {
    vec2 side = panel_texels / level_texels, low = floor(gl_FragCoord.xy) * side, high = low + side;
    written = vec4(0.0);
    for (int y = int(low.y); y < int(ceil(high.y)); ++y)
        for (int x = int(low.x); x < int(ceil(high.x)); ++x) {
            vec2 shared_part = min(high, vec2(x + 1, y + 1)) - max(low, vec2(x, y));
            written += shared_part.x * shared_part.y * texelFetch(panel, ivec2(x, y), 0);
        }
    written /= side.x * side.y;
}
#else
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy) - corner;
    vec3 q = panel_from_shown * vec3(vec2(p) + 0.5, 1.0);
    written = panel_colour(q, panel_from_shown[0], panel_from_shown[1]);
#ifdef OCCLUDED
    if (q.z * nearer < texelFetch(shown_inverse_depth, p, 0).r) written = vec4(0.0);
#endif
#ifdef ENCODED
    written.rgb = encoded_of(written.rgb / max(written.a, 1e-6));
#endif
}
#endif
