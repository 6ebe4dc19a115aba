// Scatters each rendered pixel to the shown pixel it lands in; the nearest one wins, ties as in
// lib/scatter_depth.glsl.
// In: rendered pixel and inverse depth. Out: shown colour; coverage 0 where nothing landed (cracks
// and disocclusions alike).
// Source: Westover-style point splatting with a z-buffer by 32-bit atomics, as Schuetz et al. 2021
// (arXiv 2104.07526), section 3.
//
// PASS 0 finds the nearest key of each shown pixel, PASS 1 copies the colour of the rendered pixel
// that holds it. If two hold it, PASS 2 finds the lowest index among them, PASS 3 copies that one
// again and PASS 4 clears the winners: these three are dispatched indirectly, by a count that is 0
// without ties.
#include "lib/scatter.glsl"
#include "lib/scatter_depth.glsl"
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(rgba16f) writeonly uniform image2D shown_colour;
// A rendered pixel that finds its own key there sets tie_groups.z to 1, the z of the indirect
// dispatches that settle ties.
layout(std430, binding = 0) buffer Keys { uint key_of[]; };
layout(std430, binding = 1) buffer Ties { uint tie_groups[3]; uint spare; uint winner_of[]; };
const uint NO_WINNER = 0xFFFFFFFFu;

void visit(ivec2 rendered, vec3 base) {
    Landing to = landing(rendered, base);
    if (!to.lands) return;
    uint source = source_of(rendered);
    uint key = depth_key(to.shown_inverse_depth, rendered, source);
#if PASS == 0
    if (atomicMax(key_of[to.slot], key) == key) tie_groups[2] = 1u;
#elif PASS == 1
    if (key_of[to.slot] == key) imageStore(shown_colour, to.pixel, imageLoad(rendered_colour, rendered));
#elif PASS == 2
    if (key_of[to.slot] == key) atomicMin(winner_of[to.slot], source);
#elif PASS == 3
    if (winner_of[to.slot] == source) imageStore(shown_colour, to.pixel, imageLoad(rendered_colour, rendered));
#else
    winner_of[to.slot] = NO_WINNER;
#endif
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x) return;
    visit_all(first);
}
