// Composite transparent sheets over the shown picture: each pixel finds where its ray meets the
// rendered veil, like the warp `iterative`.
// In: shown colour and inverse depth; rendered veil, premultiplied, with its inverse depth and
// transmission. Out: shown colour.
// Source: Bowles et al. 2012, Iterative Image Warping (fixed point); Porter and Duff 1984,
// Compositing Digital Images (over).
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include "lib/rendered_surface.glsl"
#include "lib/seeds.glsl"
#include OUTPUT
uniform float most_pixels; // by which the last guess may have been off
uniform sampler2D rendered_passing;
layout(rgba16f) readonly uniform image2D picture;
layout(r32f) readonly uniform image2D shown_inverse_depth; // -1: unknown, then whatever is there lies behind
uniform float nearer; // a little above 1: the shown depth has been stored as a half float

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    ivec2 pixel = ivec2(shown);
    vec4 behind = imageLoad(picture, pixel);
    vec2 start = base.xy / base.z;
    vec2 along = parallax.xy - start * parallax.z;
    float r = seed_at(shown);
    for (int k = 0; k < PLAIN; ++k) {
        float seen = imageLoad(rendered_inverse_depth, texel_at(start + r * along)).r;
        r = is_depth(seen) && abs(seen - r) > depth_tolerance * (r + depth_floor) ? seen : r;
    }
    vec2 place = start + r * along;
    Surface surface = surface_at(place, 0.0);
    float change = (surface.depth - r) / max(1.0 - dot(surface.slope, along), 0.25);
    r = surface.known ? max(r + change, 0.0) : r;
    vec2 p = start + r * along;
    bool met = surface.known && abs(change) * length(along) <= most_pixels;
    float ratio = 1.0 - r * parallax.z; // of the depths in both views, relative to that of the map at infinity
    bool ahead = base.z > 0.0 && ratio > 0.0;
    float here = r * base.z / ratio;
    bool in_front = here * nearer >= imageLoad(shown_inverse_depth, pixel).r;
    vec2 at = colour_place(surface, p);
    vec4 sum = sampled(at);
    // Average over the covered part, as in the warps; where nothing is covered, all light passes
    float share = 1.0 / max(sum.a, 0.5);
    vec3 passing = 1.0 - (1.0 - textureLod(rendered_passing, at * rendered_pixel, 0.0).rgb) * share;
    bool shows = met && ahead && in_front && in_rendered(p) && sum.a >= 0.5 && behind.a > 0.0;
    return shows ? vec4(passing * behind.rgb + sum.rgb * share, behind.a) : behind;
}
