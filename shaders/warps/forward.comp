// Scatters each drawn pixel to the shown pixel it lands in; the nearest one stays, of equals as lib/scatter.glsl says.
// In: rendered pixel and inverse depth. Out: shown colour; coverage 0 where nothing landed (cracks and disocclusions alike).
// Source: Westover-style point splatting with a z-buffer by 32-bit atomics, as Schuetz et al. 2021 (arXiv 2104.07526), section 3.
//
// PASS 0 finds the nearest key of each shown pixel, PASS 1 copies the colour of the drawn pixel that holds it. If two hold
// it, PASS 2 finds the lowest index among them, PASS 3 copies that one again and PASS 4 forgets the winners: these three are
// dispatched indirectly, by a count that is 0 when nothing tied.
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
#include "lib/scatter.glsl"
layout(rgba16f) readonly uniform image2D late_colour;
layout(rgba16f) writeonly uniform image2D shown_colour;

void visit(ivec2 drawn, vec3 base) {
    Landing to = landing(drawn, base);
    if (!to.lands) return;
#if PASS == 0
    if (atomicMax(key_of[to.slot], to.key) == to.key) tie_groups[2] = 1u;
#elif PASS == 1
    if (key_of[to.slot] == to.key) imageStore(shown_colour, to.pixel, imageLoad(late_colour, drawn));
#elif PASS == 2
    if (key_of[to.slot] == to.key) atomicMin(winner_of[to.slot], to.source);
#elif PASS == 3
    if (winner_of[to.slot] == to.source) imageStore(shown_colour, to.pixel, imageLoad(late_colour, drawn));
#else
    winner_of[to.slot] = NO_WINNER;
#endif
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= late_size.x) return;
    // precise: as in landing(), whose own `precise` does not reach its caller.
    precise vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= late_size.y) break;
        precise vec3 here = base + H[1] * float(row);
        visit(first + ivec2(0, row), here);
    }
}
