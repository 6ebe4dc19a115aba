// One pass of SIZE x SIZE: an empty pixel with at least `minimum_count` covered neighbours takes
// their median, channel by channel.
// In: shown colour after the warp; for a SIZE above 3 the list of its holes. Out: shown colour, above
// 3 of the holes alone; pixels with too few covered neighbours stay empty (coverage 0).
// Source: the interpolation step of the 2014 thesis this project starts from.
#if SIZE == 3
#define ROWS 4 // eight would spill registers
#include "lib/rows.glsl"
#include "lib/neighbour_median.glsl"
layout(rgba16f) writeonly uniform image2D filled;
uniform ivec2 shown_size;

void main() {
    ivec2 p = first_pixel();
    if (p.x >= shown_size.x) return;
    Row below = row_at(p - ivec2(0, 1)), beside = row_at(p);
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= shown_size.y) break;
        Row above = row_at(p + ivec2(0, 1));
        imageStore(filled, p, beside.middle.a > 0.0 ? beside.middle : interpolated(below, beside, above));
        below = beside;
        beside = above;
    }
}
#else
layout(local_size_x = 64) in;
layout(rgba16f) readonly uniform image2D warped;
layout(rgba16f) writeonly uniform image2D filled;
layout(std430, binding = 2) readonly buffer Holes { uint hole_count, none_a, none_b, none_c; uint hole_at[]; };
uniform int minimum_count;
#define MOST (SIZE * SIZE - 1)
#include "lib/insertion_median.glsl"

void main() {
    for (uint hole = gl_GlobalInvocationID.x; hole < hole_count; hole += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        ivec2 p = ivec2(hole_at[hole] & 0xffffu, hole_at[hole] >> 16);
        sorted_count = 0;
        for (int k = 0; k < SIZE * SIZE; ++k) {
            vec4 colour = imageLoad(warped, p + ivec2(k % SIZE, k / SIZE) - SIZE / 2);
            if (colour.a > 0.0) insert(colour.rgb);
        }
        if (sorted_count >= minimum_count) imageStore(filled, p, vec4(middle_of_sorted(), 1.0));
    }
}
#endif
