// Gather each shown pixel along its ray: guess a depth, sample the rendered depth where the ray has
// that depth, and guess again.
// In: shown pixel, rendered inverse depth, a first guess. Out: rendered pixel where the ray meets
// the rendered surface, and its colour there.
// Source: Bowles et al. 2012, Iterative Image Warping (fixed point); Lee et al. 2018, Iterative
// Depth Warping (first guess, convergence).
//
// In the rendered picture the ray is a line, and its place is linear in the inverse depth r there:
// q = base + parallax s with r = s / q.z gives q / q.z = start + r * along.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include "lib/rendered_surface.glsl"
#ifdef SEEDED
#include "lib/seeds.glsl"
#endif
#include OUTPUT
uniform float most_pixels; // by which the last guess may have been off
uniform float sheet;       // pixels that two neighbours may part by, and still be joined

const float LEAST_RUN = 1e-6; // pixels per 1/m: a head that stays in place joins all finite depths

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    vec2 start = base.xy / base.z;
    vec2 along = parallax.xy - start * parallax.z;
#ifdef SEEDED
    float r = seed_at(shown);
#else
    float r = 0.0;
#endif
    // A plain sample takes a third of the time of a slanted one. A guess that is already on the
    // surface is kept: the seed includes its slope.
    for (int k = 0; k < PLAIN; ++k) {
        float seen = imageLoad(rendered_inverse_depth, texel_at(start + r * along)).r;
        r = is_depth(seen) && abs(seen - r) > depth_tolerance * (r + depth_floor) ? seen : r;
    }
    float joined = sheet / max(length(along), LEAST_RUN);
    // Newton steps: exact on planes, however far off the guess was.
    Surface surface;
    float change;
    for (int k = 0; k < SLANTED; ++k) {
        vec2 place = start + r * along;
        surface = surface_at(place, joined);
        change = (surface.depth - r) / max(1.0 - dot(surface.slope, along), 0.25);
        r = surface.known ? max(r + change, 0.0) : r;
    }
    vec2 p = start + r * along;
    vec4 sum = sampled(colour_place(surface, p));
#ifdef WRITES_DEPTH
    found_inverse_depth = r * base.z / (1.0 - r * parallax.z); // s as above: in the shown view
#endif
    bool met = surface.known && abs(change) * length(along) <= most_pixels;
    bool ahead = base.z > 0.0 && r * parallax.z < 1.0; // in front of both eyes
    return met && ahead && in_rendered(p) && sum.a >= 0.5 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
