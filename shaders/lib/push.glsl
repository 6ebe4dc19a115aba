// What the level above says of a texel, and the texel completed by it. Who includes it has
// colour_above() and depth_above(), and above_size.
// Source: Gortler et al. 1996, The Lumigraph, section 3.4 (push-pull); the preference for the
// farther one inside holes is this project's.
#include "lib/push_pull.glsl"

// Of a texel and the three nearest to its place, the farthest surface. holes is that of all four.
struct Guess {
    vec3 colour;
    float weight, depth, holes, border;
};

Guess from_above(ivec2 texel) {
    ivec2 own = texel / 2, other = own + 2 * (texel & 1) - 1;
    other = clamp(other, ivec2(0), above_size - 1);
    ivec2 beside = ivec2(other.x, own.y), over = ivec2(own.x, other.y);
    mat4 colour = transpose(mat4(colour_above(own), colour_above(beside), colour_above(over), colour_above(other)));
    vec3 a = depth_above(own), b = depth_above(beside), c = depth_above(over), d = depth_above(other);
    vec4 depths = vec4(or_nearest(a.r), or_nearest(b.r), or_nearest(c.r), or_nearest(d.r));
    Texels four = Texels(colour[0], colour[1], colour[2], colour[3], depths, vec4(a.g, b.g, c.g, d.g), vec4(a.b, b.b, c.b, d.b));
    const vec4 shares = vec4(0.5625, 0.1875, 0.1875, 0.0625);
    vec4 borders = shares * four.border;
    float farthest = next_nearer(depths, borders, -1.0);
    float least = dot(borders, vec4(1.0)) * least_share(texel, farthest);
    while (farthest < UNKNOWN && !is_enough(border_beside(depths, borders, farthest), least)) {
        farthest = next_nearer(depths, borders, farthest);
    }
    Sum sum = NOTHING;
    add(sum, four, shares, farthest);
    float inverse = sum.weight > 0.0 ? 1.0 / sum.weight : 0.0;
    return Guess(sum.colour * inverse, sum.weight > 0.0 ? 1.0 : 0.0, sum.weight > 0.0 ? sum.depth * inverse : UNKNOWN,
                 dot(four.holes, shares), sum.border);
}

// least_holes: the share of holes from which on a level's background overrides the one below.
Texel pushed(ivec2 texel, vec4 colour, vec3 depth, float least_holes) {
    float own = or_nearest(depth.r);
    Guess up = from_above(texel);
    // If they are one surface, both count. Where the level above is mostly hole, its colours are
    // those of the hole's two sides, and the nearer side was not what was occluded. Where the nearer
    // side would lie outside the rendered view it may go on: there it counts too.
    float not_nearer = is_beside(own, up.depth);
    float behind_counts = smoothstep(0.5 * least_holes, 1.5 * least_holes, up.holes)
                        * in_rendered_view(texel, own);
    float keep = mix(1.0, colour.a, are_same(vec4(own), up.depth).x) * mix(1.0, not_nearer, behind_counts);
    keep = colour.a == 0.0 || up.weight == 0.0 ? sign(colour.a) : keep;
    bool both_known = max(own, up.depth) < MOST_KNOWN;
    float both = keep == 1.0 ? own : both_known ? mix(up.depth, own, keep) : up.depth;
    vec4 light = vec4(mix(up.colour, colour.rgb, keep), max(sign(colour.a), up.weight));
    return Texel(light, vec3(as_stored(both), depth.g, mix(up.border, depth.b, keep)));
}
