// One level of the pyramid that `pyramid` fills holes from, and the combination of its texels: only
// the background counts. Four texels of a row are one vector each of what they hold: arrays of
// structures take llvmpipe twice as long.
// Who includes it has least_border: a farthest surface must make up this share of all hole borders
// there: little on levels that see a hole and not much else; above them a glimpse of the sky is no
// background for everything around.
#include "lib/behind.glsl"

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

bool is_enough(float border, float of_all) {
    return border > 0.0 && border >= least_border * of_all;
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
