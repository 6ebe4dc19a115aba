// PASS 0 stretches the background into each empty pixel, along the epipolar line on which points
// move with the head. PASS 1 smooths these streaks.
// In: shown colour, its inverse depth in 1/m, -1 unknown; H, e rendered -> shown. Out: the same
// with holes filled; pixels that find nothing stay empty.
// Source: Mark 1999 (Post-Rendering 3D Image Warping, UNC TR99-022): filled from the background
// along epipolar lines, then blurred.
#define ROWS 4 // of a piece
#include "lib/hole_columns.glsl"
#include "lib/coverage.glsl"
#include "lib/warp_map.glsl"
#include "lib/behind.glsl"
layout(rgba16f) readonly uniform image2D warped;
uniform float least_parallax; // pixels at 1 m: below it the head counts as only turned

// The direction in which nearer points move with the head, scaled to a pixel on its longer axis:
// the derivative of the position of a point of inverse depth r, (q + e r) / (q.z + e.z r), by r, up
// to its length. 0 where nothing moves.
vec2 nearer_goes(vec2 centre) {
    vec2 towards = e.xy - centre * e.z;
    float longer = max(abs(towards.x), abs(towards.y));
    return longer >= least_parallax ? towards / longer : vec2(0.0);
}

#if PASS == 0
layout(std430, binding = 1) readonly buffer Stamps { uvec2 stamp_of[]; };
layout(r32f) readonly uniform image2D warped_depth;
layout(r32f) writeonly uniform image2D filled_depth;
layout(rgba16f) writeonly uniform image2D streaks; // alpha: distance from the source in pixels, 0 for none
uniform mat3 back_H;    // shown -> rendered
uniform vec3 back_e;
uniform vec2 rendered_size;
uniform uint stamp;     // the stamp of pieces with a covered pixel
const float MOST_TAPS = 4.0;

// A hit on a line: how many steps away, 0 for nothing, its colour and its inverse depth, UNKNOWN if
// it has none.
struct Found {
    float away, depth;
    vec3 colour;
};
const Found NOTHING = Found(0.0, UNKNOWN, vec3(0.0));

ivec2 pixel_at(vec2 centre, vec2 line, float away) {
    return ivec2(floor(centre + line * away));
}

// Number of steps that stay in a piece, from a place in it.
float steps_in_piece(vec2 place, ivec2 piece, vec2 line) {
    vec2 low = vec2(piece), high = low + vec2(PIECE_WIDE, PIECE_HIGH);
    vec2 ahead = mix(low, high, greaterThan(line, vec2(0.0))) - place;
    vec2 steps = vec2(line.x == 0.0 ? 1e9 : ahead.x / line.x, line.y == 0.0 ? 1e9 : ahead.y / line.y);
    return max(floor(min(steps.x, steps.y)), 1.0);
}

// The first covered pixel; pieces without any are skipped. A line of length 0 leads nowhere.
float first_covered(vec2 centre, vec2 line) {
    float away = 1.0, found = 0.0;
    bool pending = line != vec2(0.0);
    while (pending) {
        vec2 place = centre + line * away;
        ivec2 pixel = ivec2(floor(place));
        bool is_inside = all(lessThan(uvec2(pixel), uvec2(shown_size)));
        ivec2 piece = pixel / ivec2(PIECE_WIDE, PIECE_HIGH);
        bool any_covered = stamp_of[is_inside ? piece.y * pieces_in_a_row() + piece.x : 0].y == stamp;
        bool covered = is_inside && imageLoad(warped, pixel).a > HIDDEN;
        found = covered ? away : 0.0;
        pending = is_inside && !covered;
        away += any_covered ? 1.0 : steps_in_piece(place, piece * ivec2(PIECE_WIDE, PIECE_HIGH), line);
    }
    return found;
}

float depth_at(ivec2 pixel) {
    return or_nearest(imageLoad(warped_depth, pixel).r);
}

// The mean of a few pixels from a covered one on (at most as many as the hole is wide before it),
// as long as they are one surface, each with half the weight of the one before.
Found gathered(vec2 centre, vec2 line, float away) {
    Found found = Found(away, depth_at(pixel_at(centre, line, away)), vec3(0.0));
    float weight = 1.0, total = 0.0, taps = min(away, MOST_TAPS);
    for (float tap = 0.0; tap < taps; ++tap) {
        ivec2 pixel = pixel_at(centre, line, away + tap);
        vec4 colour = imageLoad(warped, pixel);
        float depth = depth_at(pixel);
        bool same = colour.a > 0.0 && depth <= nearest_beside(found.depth) && found.depth <= nearest_beside(depth);
        weight = same ? weight : 0.0;
        found.colour += weight * colour.rgb;
        total += weight;
        weight *= 0.5;
    }
    found.colour /= max(total, 1.0);
    return away > 0.0 ? found : NOTHING;
}

// The farther one; of one surface both, weighted towards the closer. If neither depth is known, the
// first one.
Found behind(Found a, Found b) {
    bool has_a = a.away > 0.0, has_b = b.away > 0.0;
    bool take_a = has_a && (!has_b || a.depth <= nearest_beside(b.depth)), take_b = has_b && (!has_a || b.depth <= nearest_beside(a.depth));
    take_b = take_b && !(take_a && a.depth >= MOST_KNOWN);
    if (take_a && take_b) {
        float part = a.away / (a.away + b.away);
        return Found(min(a.away, b.away), mix(a.depth, b.depth, part), mix(a.colour, b.colour, part));
    }
    if (take_a) return a;
    if (take_b) return b;
    return NOTHING;
}

// Whether the place lies in the rendered picture. Outside it nothing was occluded, and no line
// leads to it.
bool was_in_view(vec2 centre, float depth) {
    vec3 rendered = back_H * vec3(centre, 1.0) + back_e * (depth < MOST_KNOWN ? depth : 0.0);
    vec2 place = rendered.xy / rendered.z;
    return rendered.z > 0.0 && all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, rendered_size));
}

void visit(ivec2 pixel) {
    vec2 centre = vec2(pixel) + 0.5, line = nearer_goes(centre);
    float hidden_side = first_covered(centre, -line), near_side = first_covered(centre, hidden_side > 0.0 ? line : vec2(0.0));
    Found found = behind(gathered(centre, -line, hidden_side), gathered(centre, line, near_side));
    // The near side alone does not show what it occluded; and a surface that ends at the picture's
    // border may continue outside the rendered picture.
    bool known = hidden_side > 0.0 && was_in_view(centre, found.depth) && (near_side > 0.0 || was_in_view(centre, UNKNOWN));
    if (!known) found = NOTHING;
    imageStore(streaks, pixel, vec4(found.colour, found.away));
    imageStore(filled_depth, pixel, vec4(found.away > 0.0 ? as_stored(found.depth) : -1.0));
}
#else
layout(r32f) readonly uniform image2D filled_depth;
layout(rgba16f) readonly uniform image2D streaks;
layout(rgba16f) writeonly uniform image2D filled;
// Pixels between two samples across the streaks, per pixel from their source; below one there is no
// smoothing
uniform float spread;
const int REACH = 3;

// Samples across the streak, spaced wider the longer it is, from streaks of the same surface, with
// weights that fall with distance.
void visit(ivec2 pixel) {
    vec2 centre = vec2(pixel) + 0.5, line = nearer_goes(centre);
    vec2 across = line == vec2(0.0) ? vec2(1.0, 0.0) : vec2(-line.y, line.x);
    vec4 own = imageLoad(streaks, pixel);
    float depth = or_nearest(imageLoad(filled_depth, pixel).r), apart = own.a * spread;
    vec4 sum = vec4(own.rgb, 1.0);
    int last = apart > 1.0 ? REACH : -REACH - 1;
    for (int tap = -REACH; tap <= last; ++tap) {
        ivec2 beside = ivec2(floor(centre + across * (apart * float(tap))));
        vec4 streak = imageLoad(streaks, beside);
        float its = or_nearest(imageLoad(filled_depth, beside).r);
        bool empty = imageLoad(warped, beside).a == 0.0 && all(lessThan(uvec2(beside), uvec2(shown_size)));
        bool same = tap != 0 && empty && streak.a > 0.0 && its <= nearest_beside(depth) && depth <= nearest_beside(its);
        sum += same ? vec4(streak.rgb, 1.0) / float(1 + abs(tap)) : vec4(0.0);
    }
    imageStore(filled, pixel, own.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0));
}
#endif

void main() {
    ivec2 p = first_of_column();
    if (p.x >= shown_size.x) return;
    // llvmpipe runs the body of an `if` for all pixels if any needs it, so a loop visits the empty
    // pixels of the column one by one.
    uint left = 0u;
    for (int row = 0; row < ROWS; ++row) left |= p.y + row < shown_size.y && imageLoad(warped, p + ivec2(0, row)).a == 0.0 ? 1u << row : 0u;
    if (left == 0u) return;
    do visit(p + ivec2(0, findLSB(left))); while ((left &= left - 1u) != 0u);
}
