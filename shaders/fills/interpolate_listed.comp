// One pass of SIZE x SIZE over the list of holes: one with at least `minimum_count` covered
// neighbours takes their median, channel by channel.
// In: shown colour after the warp, and its list of holes. Out: shown colour of holes that are filled.
// Source: the interpolation step of the 2014 thesis this project starts from.
layout(local_size_x = 64) in;
layout(rgba16f) readonly uniform image2D warped;
layout(rgba16f) writeonly uniform image2D filled;
layout(std430, binding = 2) readonly buffer Holes { uint hole_count, none_a, none_b, none_c; uint hole_at[]; };
uniform int minimum_count;
#define MOST (SIZE * SIZE - 1)
#include "lib/insertion_median.glsl"
#include "lib/coverage.glsl"

void main() {
    uint hole = gl_GlobalInvocationID.x;
    if (hole >= hole_count) return;
    for (; hole < hole_count; hole += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        ivec2 p = ivec2(hole_at[hole] & 0xffffu, hole_at[hole] >> 16);
        sorted_count = 0;
        for (int k = 0; k < SIZE * SIZE; ++k) {
            vec4 colour = imageLoad(warped, p + ivec2(k % SIZE, k / SIZE) - SIZE / 2);
            if (colour.a > HIDDEN) insert(colour.rgb);
        }
        if (sorted_count >= minimum_count) imageStore(filled, p, vec4(middle_of_sorted(), 1.0));
    }
}
