// One level of the pyramid that `pyramid` fills holes from, and the combination of its texels: only
// the background counts.
#include "lib/behind.glsl"

// colour: the mean of the hole borders below a texel. weight: 0..1, 0 for nothing. depth: its
// inverse depth, UNKNOWN if it has none.
// holes: the share of empty pixels below the texel. border: the share of pixels below the texel
// that border on holes and have that depth.
struct Texel {
    vec3 colour;
    float weight, depth, holes, border;
};

struct Sum {
    vec3 colour;
    float weight, depth, border;
};
const Sum NOTHING = Sum(vec3(0.0), 0.0, 0.0, 0.0);

// Add a texel with its share, reduced where it is nearer than the farthest that counts, or a
// glimpse of something farther.
void add(inout Sum sum, Texel texel, float share, float farthest) {
    float beside = share * is_beside(texel.depth, farthest) * is_beside(farthest, texel.depth), counts = beside * texel.weight;
    sum.colour += counts * texel.colour;
    sum.depth += counts > 0.0 ? counts * texel.depth : 0.0;
    sum.weight += counts;
    sum.border += beside * texel.border;
}

// A farthest surface must make up this share of all hole borders there: little on levels that see a
// hole and not much else; above them a glimpse of the sky is no background for everything around.
uniform float least_border;

bool is_enough(float border, float of_all) {
    return border > 0.0 && border >= least_border * of_all;
}

// The border weight, among four, at a depth.
float border_beside(vec4 depths, vec4 borders, float depth) {
    return dot(borders, vec4(lessThanEqual(depths, vec4(nearest_beside(depth)))));
}
