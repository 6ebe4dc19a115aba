// After the scatter of `forward`: the shown inverse depth, which its keys hold.
// In: the keys of lib/scatter_depth.glsl. Out: inverse depth in 1/m, -1 where nothing landed, 0
// beyond 1000 km.
// Source: lib/scatter_depth.glsl, the other way round.
#include "lib/rows.glsl"
#include "lib/scatter_sizes.glsl"
#include "lib/scatter_depth.glsl"
layout(r32f) writeonly uniform image2D shown_inverse_depth;
layout(std430, binding = 0) readonly buffer Keys { uint key_of[]; };

void main() {
    ivec2 p = first_pixel();
    if (p.x >= shown_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= shown_size.y) break;
        uint key = key_of[p.y * shown_size.x + p.x];
        float depth = key < FAR_KEYS ? 0.0 : uintBitsToFloat(FARTHEST_BITS + (key - FAR_KEYS) / 16u);
        imageStore(shown_inverse_depth, p, vec4(key == 0u ? -1.0 : depth));
    }
}
