// A texel of one level of the pyramid from the 4 x 4 below it, or (FROM_PICTURE 1) from pixels.
// Who includes it has colour_below() and depth_below(), all 0 outside, below_size, and (FROM_PICTURE
// 0) crack_border: the weight of a crack's border, next to nothing, applied at the second level.
// Source: Gortler et al. 1996, The Lumigraph, section 3.4 (push-pull); the restriction to the
// farthest surface is this project's.
#include "lib/push_pull.glsl"
#include "lib/coverage.glsl"
const vec4 KERNEL = vec4(0.125, 0.375, 0.375, 0.125);
const float GAIN = 4.0;               // so that one full texel of four makes a full one
const float LEAST = 1.0 / 1024.0;     // keeps weights from vanishing in half floats, however many levels they pass
#if FROM_PICTURE
const float CRACKS = 1.0 / 1048576.0;
#else
const float DEEP = 1.0 / 128.0;
#endif

// The four texels below from `from` on.
Texels row_from(ivec2 from) {
    ivec2 second = from + ivec2(1, 0), third = from + ivec2(2, 0), fourth = from + ivec2(3, 0);
    mat4 colour = transpose(mat4(colour_below(from), colour_below(second), colour_below(third),
                                 colour_below(fourth)));
    Texels row;
    row.red = colour[0];
    row.green = colour[1];
    row.blue = colour[2];
    row.weight = colour[3];
    vec4 depth;
#if FROM_PICTURE
    depth = vec4(depth_below(from), depth_below(second), depth_below(third), depth_below(fourth));
    row.holes = vec4(lessThanEqual(row.weight, vec4(0.0)));
    row.weight *= vec4(greaterThan(row.weight, vec4(HIDDEN)));
    row.border = row.weight;
#else
    vec3 a = depth_below(from), b = depth_below(second), c = depth_below(third), d = depth_below(fourth);
    depth = vec4(a.r, b.r, c.r, d.r);
    row.holes = vec4(a.g, b.g, c.g, d.g);
    row.border = vec4(a.b, b.b, c.b, d.b);
#endif
    row.depth = vec4(or_nearest(depth.x), or_nearest(depth.y), or_nearest(depth.z), or_nearest(depth.w));
    return row;
}

// Of the four from `from` on: the shares of empty pixels, and of what lies inside the picture.
vec2 holes_of(Texels row, ivec2 from) {
    vec4 inside = KERNEL * vec4(lessThan(uvec4(from.x, from.x + 1, from.x + 2, from.x + 3), uvec4(below_size.x)));
    inside = uint(from.y) < uint(below_size.y) ? inside : vec4(0.0);
    return vec2(dot(inside, row.holes), dot(inside, vec4(1.0)));
}

// The farthest of the sixteen that is not an outlier.
float farthest_of_enough(ivec2 texel, Texels a, Texels b, Texels c, Texels d) {
#if FROM_PICTURE
    vec4 upper = min(mix(vec4(UNKNOWN), a.depth, greaterThan(a.weight, vec4(0.0))), mix(vec4(UNKNOWN), b.depth, greaterThan(b.weight, vec4(0.0))));
    vec4 lower = min(mix(vec4(UNKNOWN), c.depth, greaterThan(c.weight, vec4(0.0))), mix(vec4(UNKNOWN), d.depth, greaterThan(d.weight, vec4(0.0))));
    return least_of(min(upper, lower));
#else
    vec4 outer = KERNEL.x * KERNEL, inner = KERNEL.y * KERNEL;
    vec4 in_a = outer * mix(vec4(0.0), a.border, greaterThan(a.weight, vec4(0.0)));
    vec4 in_b = inner * mix(vec4(0.0), b.border, greaterThan(b.weight, vec4(0.0)));
    vec4 in_c = inner * mix(vec4(0.0), c.border, greaterThan(c.weight, vec4(0.0)));
    vec4 in_d = outer * mix(vec4(0.0), d.border, greaterThan(d.weight, vec4(0.0)));
    float nearest = max(max(nearest_of(a.depth, in_a), nearest_of(b.depth, in_b)), max(nearest_of(c.depth, in_c), nearest_of(d.depth, in_d)));
    float least = dot(in_a + in_b + in_c + in_d, vec4(1.0)) * least_share(texel, nearest), farthest = -1.0;
    // The nearer a depth, the more is as far: from the farthest on until it is enough.
    for (bool going = true; going;) {
        farthest = min(min(next_nearer(a.depth, in_a, farthest), next_nearer(b.depth, in_b, farthest)),
                       min(next_nearer(c.depth, in_c, farthest), next_nearer(d.depth, in_d, farthest)));
        float beside = border_beside(a.depth, in_a, farthest) + border_beside(b.depth, in_b, farthest)
                     + border_beside(c.depth, in_c, farthest) + border_beside(d.depth, in_d, farthest);
        going = farthest < UNKNOWN && !is_enough(beside, least);
    }
    return farthest;
#endif
}

// Of the 4 x 4 texels below that a texel spans: the farthest surface. holes, inside: sums of
// holes_of.
Texel pulled(ivec2 texel, Texels a, Texels b, Texels c, Texels d, float holes, float inside) {
    float farthest = farthest_of_enough(texel, a, b, c, d);
    Sum sum = NOTHING;
    add(sum, a, KERNEL.x * KERNEL, farthest);
    add(sum, b, KERNEL.y * KERNEL, farthest);
    add(sum, c, KERNEL.z * KERNEL, farthest);
    add(sum, d, KERNEL.w * KERNEL, farthest);
    float weight = sum.weight > 0.0 ? clamp(GAIN * sum.weight, LEAST, 1.0) : 0.0;
    float over = sum.weight > 0.0 ? 1.0 / sum.weight : 0.0;
#if FROM_PICTURE
    // Cracks hide nothing: the next level only records that they exist.
    holes = weight > 0.0 ? CRACKS : holes;
#else
    sum.border *= holes >= DEEP * inside ? 1.0 : crack_border;
#endif
    float depth = as_stored(weight > 0.0 ? sum.depth * over : UNKNOWN);
    return Texel(vec4(sum.colour * over, weight), vec3(depth, holes / inside, sum.border));
}
