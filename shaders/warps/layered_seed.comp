// Scatters a picture's inverse depth: the nearest that lands in each shown pixel, from which a
// gather starts its search for the surface.
// In: rendered pixel and inverse depth. Out: seed_of each shown pixel.
// Source: Lee et al. 2018, Iterative Depth Warping, section 4 (a forward warp of depth alone seeds
// a gather); Schuetz et al. 2021 (atomics).
#include "lib/scatter.glsl"
#include "lib/seed_keys.glsl"

void visit(ivec2 rendered, vec3 base) {
    Landing to = landing(rendered, base);
    if (to.lands) atomicMax(seed_of[to.slot], seed_key(to.shown_inverse_depth));
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x) return;
    visit_all(first);
}
