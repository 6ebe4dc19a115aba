// Completes one level of the pyramid from the one above, or (INTO_PICTURE 1) fills the empty pixels
// of the picture from the first one.
// In: colour and weight, inverse depth in 1/m and share of empty pixels of the level above. Out: of
// this one; or the guesses.
// Source: Gortler et al. 1996, The Lumigraph, section 3.4 (push-pull); the preference for the
// farther one inside holes is this project's.
#if LISTED
#define ROWS 4 // of a piece; of a level, shown_size is that of the level
#include "lib/hole_columns.glsl"
#else
#define ROWS 4
#include "lib/rows.glsl"
#endif
#include "lib/push_pull.glsl"
layout(rgba16f) readonly uniform image2D above_colour;
layout(rgba32f) readonly uniform image2D above_depth;
uniform ivec2 above_size;

// Of a texel and the three nearest to its place, the farthest surface. holes is that of all four.
struct Guess {
    vec3 colour;
    float weight, depth, holes, border;
};

Guess from_above(ivec2 texel) {
    ivec2 own = texel / 2, other = own + 2 * (texel & 1) - 1;
    other = clamp(other, ivec2(0), above_size - 1);
    ivec2 beside = ivec2(other.x, own.y), over = ivec2(own.x, other.y);
    mat4 colour = transpose(mat4(imageLoad(above_colour, own), imageLoad(above_colour, beside), imageLoad(above_colour, over),
                                 imageLoad(above_colour, other)));
    vec3 a = imageLoad(above_depth, own).rgb, b = imageLoad(above_depth, beside).rgb;
    vec3 c = imageLoad(above_depth, over).rgb, d = imageLoad(above_depth, other).rgb;
    vec4 depths = vec4(or_nearest(a.r), or_nearest(b.r), or_nearest(c.r), or_nearest(d.r));
    Texels four = Texels(colour[0], colour[1], colour[2], colour[3], depths, vec4(a.g, b.g, c.g, d.g), vec4(a.b, b.b, c.b, d.b));
    const vec4 shares = vec4(0.5625, 0.1875, 0.1875, 0.0625);
    vec4 borders = shares * four.border;
    float all = dot(borders, vec4(1.0)), farthest = -1.0;
    for (bool going = true; going;) {
        farthest = next_nearer(depths, borders, farthest);
        going = farthest < UNKNOWN && !is_enough(border_beside(depths, borders, farthest), all);
    }
    Sum sum = NOTHING;
    add(sum, four, shares, farthest);
    float inverse = sum.weight > 0.0 ? 1.0 / sum.weight : 0.0;
    return Guess(sum.colour * inverse, sum.weight > 0.0 ? 1.0 : 0.0, sum.weight > 0.0 ? sum.depth * inverse : UNKNOWN,
                 dot(four.holes, shares), sum.border);
}

#if INTO_PICTURE
layout(rgba16f) readonly uniform image2D warped;
layout(rgba16f) writeonly uniform image2D filled;
#if WITH_DEPTH
layout(r32f) writeonly uniform image2D filled_depth;
#endif

bool is_wanted(ivec2 pixel) {
    return pixel.y < shown_size.y && imageLoad(warped, pixel).a == 0.0;
}

void push(ivec2 pixel) {
    Guess guess = from_above(pixel);
    imageStore(filled, pixel, vec4(guess.colour, guess.weight));
#if WITH_DEPTH
    imageStore(filled_depth, pixel, vec4(as_stored(guess.depth)));
#endif
}
#else
layout(rgba16f) uniform image2D level_colour;
layout(rgba32f) uniform image2D level_depth;
uniform ivec2 level_size;
uniform float least_holes; // the share of holes from which on a level's background overrides the one below

// Texels with holes never read texels without holes below them.
bool is_wanted(ivec2 texel) {
    return texel.y < level_size.y && imageLoad(level_depth, texel).g > 0.0;
}

void push(ivec2 texel) {
    vec4 colour = imageLoad(level_colour, texel);
    vec3 depth = imageLoad(level_depth, texel).rgb;
    float own = or_nearest(depth.r);
    Guess up = from_above(texel);
    // If they are one surface, both count. Where the level above is mostly hole, its colours are
    // those of the hole's two sides, and the nearer side was not what was occluded.
    float not_nearer = is_beside(own, up.depth);
    float behind_counts = smoothstep(0.5 * least_holes, 1.5 * least_holes, up.holes);
    float keep = mix(1.0, colour.a, are_same(vec4(own), up.depth).x) * mix(1.0, not_nearer, behind_counts);
    keep = colour.a == 0.0 || up.weight == 0.0 ? sign(colour.a) : keep;
    bool both_known = max(own, up.depth) < MOST_KNOWN;
    float both = keep == 1.0 ? own : both_known ? mix(up.depth, own, keep) : up.depth;
    imageStore(level_colour, texel, vec4(mix(up.colour, colour.rgb, keep), max(sign(colour.a), up.weight)));
    imageStore(level_depth, texel, vec4(as_stored(both), depth.g, mix(up.border, depth.b, keep), 0.0));
}
#endif

void main() {
#if LISTED
    ivec2 p = first_of_column();
    if (p.x >= shown_size.x) return;
#else
    ivec2 p = first_pixel();
    if (p.x >= level_size.x) return;
#endif
    // llvmpipe runs the body of an `if` for all pixels if any needs it, so a loop visits the
    // selected pixels of the column one by one.
    uint left = 0u;
    for (int row = 0; row < ROWS; ++row) left |= is_wanted(p + ivec2(0, row)) ? 1u << row : 0u;
    for (; left != 0u; left &= left - 1u) push(p + ivec2(0, findLSB(left)));
}
