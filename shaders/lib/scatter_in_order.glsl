// A scatter without depth comparison: of the drawn pixels that land in one shown pixel the last in an order given beforehand stays.
// PASS 0 keeps the largest place in the order, whichever invocation comes first; PASS 1 copies the colours. The shader gives
// `order_of`, below 2^32 - 1 and different for every drawn pixel, and its inverse `drawn_of`.
#include "lib/scatter_sizes.glsl"
layout(std430, binding = 0) buffer Keys { uint key_of[]; }; // 0 = nothing landed, else 1 + the place in the order
uint order_of(ivec2 drawn);
ivec2 drawn_of(uint order);

#if PASS == 0
#include "lib/scatter.glsl"

void visit(ivec2 drawn, vec3 base) {
    Landing to = landing(drawn, base);
    if (to.lands) atomicMax(key_of[to.slot], order_of(drawn) + 1u);
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
    return key == 0u ? ivec2(-1) : drawn_of(key - 1u);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    resolve_all(first);
}
#endif
