// One level of the pyramid that `pyramid` fills holes from, and how its texels are put together:
// what lies behind counts alone.
#include "lib/behind.glsl"

// colour: the mean of what borders on holes below a texel. weight: 0..1, 0 for nothing. depth: its
// inverse depth, UNKNOWN if it has none.
// holes: the share of empty pixels below the texel. border: how much of what is below the texel
// borders on holes and has that depth.
struct Texel {
    vec3 colour;
    float weight, depth, holes, border;
};

struct Sum {
    vec3 colour;
    float weight, depth, border;
};
const Sum NOTHING = Sum(vec3(0.0), 0.0, 0.0, 0.0);

// Adds a texel with its share, less where it is nearer than the farthest that counts, and where it
// is a glimpse of what is farther still.
void add(inout Sum sum, Texel texel, float share, float farthest) {
    float beside = share * is_beside(texel.depth, farthest) * is_beside(farthest, texel.depth), counts = beside * texel.weight;
    sum.colour += counts * texel.colour;
    sum.depth += counts > 0.0 ? counts * texel.depth : 0.0;
    sum.weight += counts;
    sum.border += beside * texel.border;
}

// Of all that borders on holes there, a farthest one with what is of one surface with it must be
// this share: little on levels that see a hole and not much else; above them a glimpse of the sky
// is no background for everything around.
uniform float least_border;

bool is_enough(float border, float of_all) {
    return border > 0.0 && border >= least_border * of_all;
}

// How much of four is as far as a depth.
float border_beside(vec4 depths, vec4 borders, float depth) {
    return dot(borders, vec4(lessThanEqual(depths, vec4(nearest_beside(depth)))));
}
