// A scatter without depth comparison: of the rendered pixels that land in one shown pixel, the last
// in a fixed order wins. PASS 0 keeps the largest rank, in any order of execution; PASS 1 copies
// the colours. The shader defines `order_of`, below 2^32 - 1 and different for every rendered
// pixel, and its inverse `rendered_of`.
#include "lib/scatter_sizes.glsl"
#include "lib/warp_map.glsl"
layout(std430, binding = 0) buffer Keys { uint key_of[]; }; // 0 = nothing landed, else 1 + the rank
uint order_of(ivec2 rendered);
ivec2 rendered_of(uint order);

#if PASS == 0
#include "lib/scatter.glsl"

void visit(ivec2 rendered, vec3 base) {
    Landing to = landing(rendered, base);
    if (to.lands) atomicMax(key_of[to.slot], order_of(rendered) + 1u);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x) return;
    visit_all(first);
}
#else
#include "lib/scatter_resolve.glsl"

ivec2 winner(uint slot) {
    uint key = key_of[slot];
    key_of[slot] = 0u;
    return key == 0u ? ivec2(-1) : rendered_of(key - 1u);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    resolve_all(first);
}
#endif
