// Count the uncovered pixels of a picture.
// In: colours with coverage in alpha. Out: added to counts[slot].
// Source: none; each invocation adds to shared memory, each work group once to the buffer.
#include "lib/rows.glsl"
layout(std430, binding = 0) buffer Counts { uint counts[]; };
layout(rgba16f) readonly uniform image2D picture;
uniform ivec2 size;
uniform int slot;

shared uint holes;

void main() {
    if (gl_LocalInvocationIndex == 0u) holes = 0u;
    barrier();
    ivec2 p = first_pixel();
    uint own = 0u;
    if (p.x < size.x) {
        for (int row = 0; row < ROWS && p.y < size.y; ++row, ++p.y) own += imageLoad(picture, p).a == 0.0 ? 1u : 0u;
    }
    if (own > 0u) atomicAdd(holes, own);
    barrier();
    if (gl_LocalInvocationIndex == 0u && holes > 0u) atomicAdd(counts[slot], holes);
}
