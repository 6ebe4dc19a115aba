// Compute one level of the pyramid from the one below, or (FROM_PICTURE 1) the first one from the
// shown picture.
// In: colour and weight, inverse depth in 1/m and share of empty pixels of the level below. Out:
// the same, of half the size, where a hole is near.
// Source: Gortler et al. 1996, The Lumigraph, section 3.4 (push-pull); the restriction to the
// farthest surface is this project's.
#if FROM_PICTURE
#define ROWS 4 // of a piece; of a level, shown_size is that of the level
#include "lib/hole_columns.glsl"
#else
#define ROWS 4
#include "lib/rows.glsl"
#endif
layout(rgba16f) readonly uniform image2D below_colour;
layout(rgba16f) writeonly uniform image2D level_colour;
layout(rgba32f) writeonly uniform image2D level_depth;
uniform ivec2 below_size, level_size;
uniform float least_border, texel_pixels;

vec4 colour_below(ivec2 texel) {
    return imageLoad(below_colour, texel);
}

#if FROM_PICTURE
layout(r32f) readonly uniform image2D below_depth;

float depth_below(ivec2 texel) {
    return imageLoad(below_depth, texel).r;
}
#else
layout(rgba32f) readonly uniform image2D below_depth;
uniform float crack_border;

vec3 depth_below(ivec2 texel) {
    return imageLoad(below_depth, texel).rgb;
}
#endif
#include "lib/pull.glsl"

void store(ivec2 texel, Texel made) {
    imageStore(level_colour, texel, made.colour);
    imageStore(level_depth, texel, vec4(made.depth, 0.0));
}

void main() {
#if FROM_PICTURE
    ivec2 texel = first_of_column();
    if (texel.x >= level_size.x) return;
#else
    ivec2 texel = first_pixel();
    if (texel.x >= level_size.x) return;
#endif
    // The upper half of one texel is the lower half of the next one in the column, so it is read
    // once.
    ivec2 from = 2 * texel - 1;
    Texels a, b, c = row_from(from), d = row_from(from + ivec2(0, 1));
    vec2 lower, upper = KERNEL.x * holes_of(c, from) + KERNEL.y * holes_of(d, from + ivec2(0, 1));
    for (int row = 0; row < ROWS; ++row, ++texel.y) {
        if (texel.y >= level_size.y) break;
        from = 2 * texel + ivec2(-1, 1);
        a = c;
        b = d;
        c = row_from(from);
        d = row_from(from + ivec2(0, 1));
        vec2 of_c = holes_of(c, from), of_d = holes_of(d, from + ivec2(0, 1));
        lower = upper;
        upper = KERNEL.x * of_c + KERNEL.y * of_d;
        vec2 all = lower + KERNEL.y * of_c + KERNEL.x * of_d;
        bool counts = all.x > 0.0;
        // llvmpipe runs the body of an `if` for all invocations if any needs it, that of a loop for
        // none if none does.
        for (; counts; counts = false) store(texel, pulled(texel, a, b, c, d, all.x, all.y));
    }
}
