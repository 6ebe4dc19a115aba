// One level of the pyramid that `pyramid` fills holes from, and the combination of its texels: only
// the background counts. Four texels of a row are one vector each of what they hold: arrays of
// structures take llvmpipe twice as long.
// Who includes it has least_border, the share of all hole borders that a farthest surface must make
// up: little on levels that see a hole and not much else; above them a glimpse of the sky is no
// background for everything around. And texel_pixels: pixels along a texel's side.
#include "lib/behind.glsl"
// From pixels of the shown picture to the rendered one, as in lib/warp_map.glsl.
uniform mat3 back_H;
uniform vec3 back_e;
uniform vec2 rendered_size;
uniform float least_beyond; // that share where the rendered view ends before the nearest surface does

// One texel: colour and weight; inverse depth (-1: none), share of empty pixels, border.
struct Texel {
    vec4 colour;
    vec3 depth;
};

// colour: the mean of the hole borders below a texel. weight: 0..1, 0 for nothing. depth: its
// inverse depth, UNKNOWN if it has none.
// holes: the share of empty pixels below the texel. border: the share of pixels below the texel
// that border on holes and have that depth.
struct Texels {
    vec4 red, green, blue, weight, depth, holes, border;
};

struct Sum {
    vec3 colour;
    float weight, depth, border;
};
const Sum NOTHING = Sum(vec3(0.0), 0.0, 0.0, 0.0);

// Add four texels with their shares, reduced where they are nearer than the farthest that counts,
// or a glimpse of something farther.
void add(inout Sum sum, Texels texels, vec4 shares, float farthest) {
    vec4 beside = shares * are_same(texels.depth, farthest), counts = beside * texels.weight;
    sum.colour += vec3(dot(counts, texels.red), dot(counts, texels.green), dot(counts, texels.blue));
    sum.depth += dot(counts, mix(vec4(0.0), texels.depth, greaterThan(counts, vec4(0.0))));
    sum.weight += dot(counts, vec4(1.0));
    sum.border += dot(beside, texels.border);
}

// 1 where the rendered view contains what lies at a texel and inverse depth, 0 where it does not. In
// between over one texel, so that nothing jumps while the head turns.
float in_rendered_view(ivec2 texel, float inverse_depth) {
    float known = inverse_depth < MOST_KNOWN ? inverse_depth : 0.0;
    vec3 place = back_H * vec3((vec2(texel) + 0.5) * texel_pixels, 1.0) + known * back_e;
    vec2 at = place.xy / place.z, gap = min(at, rendered_size - at);
    return place.z > 0.0 ? clamp(0.5 + min(gap.x, gap.y) / texel_pixels, 0.0, 1.0) : 0.0;
}

// The nearest known depth of four that borders on a hole; 0 for none.
float nearest_of(vec4 depths, vec4 borders) {
    bvec4 counts = bvec4(uvec4(greaterThan(borders, vec4(0.0))) & uvec4(lessThan(depths, vec4(MOST_KNOWN))));
    vec4 known = mix(vec4(0.0), depths, counts);
    return max(max(known.x, known.y), max(known.z, known.w));
}

// The share of all hole borders that the farthest surface must make up at a texel. In the rendered
// view the nearest one would have been seen; beyond its border that one may go on as well.
float least_share(ivec2 texel, float nearest) {
    return mix(least_beyond, least_border, in_rendered_view(texel, nearest));
}

bool is_enough(float border, float least) {
    return border > 0.0 && border >= least;
}

// The border weight, among four, at a depth.
float border_beside(vec4 depths, vec4 borders, float depth) {
    return dot(borders, vec4(lessThanEqual(depths, vec4(nearest_beside(depth)))));
}

float least_of(vec4 four) {
    return min(min(four.x, four.y), min(four.z, four.w));
}

// The farthest of four that borders on a hole and is nearer than `behind`; UNKNOWN for none.
float next_nearer(vec4 depths, vec4 borders, float behind) {
    bvec4 is_next = bvec4(uvec4(greaterThan(borders, vec4(0.0))) & uvec4(greaterThan(depths, vec4(behind))));
    return least_of(mix(vec4(UNKNOWN), depths, is_next));
}
