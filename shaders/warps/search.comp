// Gathers each shown pixel by following its ray through the rendered depth, from near to far, to
// the first surface that it meets.
// In: shown pixel, rendered inverse depth and its pyramid of bounds. Out: rendered pixel where the
// ray meets the rendered surface, and its colour.
// Source: McMillan 1997, thesis, section 7.4 (search along the epipolar line); Tevs et al. 2008
// (skipping by maximum mipmaps).
//
// In the rendered picture the ray is a line, and its place is linear in the inverse depth r there:
// start + r * along. It is followed from large r to r = 0, the point at infinity, cell by cell:
// blocks that it passes in front of or behind are skipped whole. In the smallest cells, quarters of
// texels, the surface is a plane. A ray that passes behind an edge meets nothing there and
// continues.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include "lib/rendered_surface.glsl"
#include "lib/pyramid.glsl"
#include OUTPUT
uniform float gap;   // pixels by which a ray may miss the end of a surface and still hit it
uniform float nearest; // 1/m, no rendered depth is nearer
uniform int steps;

const float STRIDE = 1e-3; // pixels beyond a border, so that rounding cannot trap the ray there

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    vec2 start = base.xy / base.z;
    vec2 along = parallax.xy - start * parallax.z;
    // Per unit of inverse depth, at least a pixel every 1e9 1/m, so that a ray that stays in place
    // needs no special case.
    vec2 run = mix(along, vec2(1e-9), lessThan(abs(along), vec2(1e-9)));
    float slack = gap / length(run), stride = STRIDE / max(abs(run.x), abs(run.y));
    vec2 at_low = -start / run, at_high = (vec2(rendered_size) - start) / run;
    vec2 enters = max(at_low, at_high), leaves = min(at_low, at_high);
    float r = min(min(enters.x, enters.y), parallax.z > 0.0 ? min(nearest, 1.0 / parallax.z) : nearest);
    float last = max(max(leaves.x, leaves.y), 0.0);
    bool going = base.z > 0.0 && r >= last, met = false;
    int level = TOP;
    vec2 p = start, place = start;
    for (int step = 0; step < steps && going; ++step) {
        float side = level == 0 ? 0.5 : float(1 << (2 * level));
        vec2 here = clamp(start + r * along, vec2(0.0), vec2(rendered_size) - 1e-3);
        vec2 cell = floor(here / side);
        // Where the ray, going towards r = 0, leaves the cell
        vec2 border = (cell + vec2(lessThan(run, vec2(0.0)))) * side;
        vec2 out_at = (border - start) / run;
        // A border already passed is one that rounding put the ray on, where it is nearly parallel:
        // use the next one.
        out_at -= mix(vec2(0.0), side / abs(run), greaterThanEqual(out_at, vec2(r)));
        float until = max(min(max(out_at.x, out_at.y), r), last);
        vec2 bounds = bounds_of[block_index(max(level, 1), ivec2(here / max(side, 4.0)))];
        bool passes = until - slack > bounds.y || r + slack < bounds.x;
        if (level > 0 && !passes) {
            r = min(r, max(bounds.y + slack, until));
            --level;
        } else {
            if (level == 0) {
                vec2 middle = start + 0.5 * (r + until) * along;
                Surface surface = surface_at(middle, 0.0);
                float facing = 1.0 - dot(surface.slope, along);
                float found = (surface.depth + dot(surface.slope, start - middle)) / max(facing, 1e-3);
                met = surface.known && facing > 1e-3 && found <= r + slack && found >= until - slack && found * parallax.z < 1.0;
                found = max(found, 0.0);
                p = start + found * along;
#ifdef WRITES_DEPTH
                found_inverse_depth = met ? found * base.z / (1.0 - found * parallax.z) : found_inverse_depth;
#endif
                place = colour_place(surface, p);
            }
            going = !met && until > last;
            r = until - stride;
            vec2 next = start + r * along;
            bool same_block = level == 0 && ivec2(next) >> 2 == ivec2(here) >> 2;
            level = same_block ? 0 : min(level + 1, TOP);
        }
    }
    vec4 sum = sampled(place);
    return met && inside(p, rendered_size) && sum.a >= 0.5 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
