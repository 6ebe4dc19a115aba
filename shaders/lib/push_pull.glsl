// One level of the pyramid that `pyramid` fills holes from, and how its texels are put together:
// what lies behind counts alone.
#include "lib/behind.glsl"

// colour: the mean of what borders on holes below a texel. weight: 0..1, 0 for nothing. depth: its inverse depth, UNKNOWN if it has none.
// holes: the share of empty pixels below the texel.
struct Texel {
    vec3 colour;
    float weight, depth, holes;
};

struct Sum {
    vec3 colour;
    float weight, depth;
};

// Adds a texel with its share, less where it is nearer than the farthest of all.
void add(inout Sum sum, Texel texel, float share, float farthest) {
    float counts = share * texel.weight * is_beside(texel.depth, farthest);
    sum.colour += counts * texel.colour;
    sum.depth += counts > 0.0 ? counts * texel.depth : 0.0;
    sum.weight += counts;
}
