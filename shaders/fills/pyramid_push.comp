// Completes one level of the pyramid from the one above, or (INTO_PICTURE 1) fills the empty pixels
// of the picture from the first one.
// In: colour and weight, inverse depth in 1/m and share of empty pixels of the level above. Out: of
// this one; or the guesses.
// Source: Gortler et al. 1996, The Lumigraph, section 3.4 (push-pull); the preference for the
// farther one inside holes is this project's.
#if LISTED
#define ROWS 4 // of a piece; of a level, shown_size is that of the level
#include "lib/hole_columns.glsl"
#else
#define ROWS 4
#include "lib/rows.glsl"
#endif
layout(rgba16f) readonly uniform image2D above_colour;
layout(rgba32f) readonly uniform image2D above_depth;
uniform ivec2 above_size;
uniform float least_border, texel_pixels;

vec4 colour_above(ivec2 texel) {
    return imageLoad(above_colour, texel);
}

vec3 depth_above(ivec2 texel) {
    return imageLoad(above_depth, texel).rgb;
}
#include "lib/push.glsl"

#if INTO_PICTURE
layout(rgba16f) readonly uniform image2D warped;
layout(rgba16f) writeonly uniform image2D filled;
#if WITH_DEPTH
layout(r32f) writeonly uniform image2D filled_depth;
#endif

bool is_wanted(ivec2 pixel) {
    return pixel.y < shown_size.y && imageLoad(warped, pixel).a == 0.0;
}

void push(ivec2 pixel) {
    Guess guess = from_above(pixel);
    imageStore(filled, pixel, vec4(guess.colour, guess.weight));
#if WITH_DEPTH
    imageStore(filled_depth, pixel, vec4(as_stored(guess.depth)));
#endif
}
#else
layout(rgba16f) uniform image2D level_colour;
layout(rgba32f) uniform image2D level_depth;
uniform ivec2 level_size;
uniform float least_holes;

// Texels with holes never read texels without holes below them.
bool is_wanted(ivec2 texel) {
    return texel.y < level_size.y && imageLoad(level_depth, texel).g > 0.0;
}

void push(ivec2 texel) {
    Texel made = pushed(texel, imageLoad(level_colour, texel), imageLoad(level_depth, texel).rgb, least_holes);
    imageStore(level_colour, texel, made.colour);
    imageStore(level_depth, texel, vec4(made.depth, 0.0));
}
#endif

void main() {
#if LISTED
    ivec2 p = first_of_column();
    if (p.x >= shown_size.x) return;
#else
    ivec2 p = first_pixel();
    if (p.x >= level_size.x) return;
#endif
    // llvmpipe runs the body of an `if` for all pixels if any needs it, so a loop visits the
    // selected pixels of the column one by one.
    uint left = 0u;
    for (int row = 0; row < ROWS; ++row) left |= is_wanted(p + ivec2(0, row)) ? 1u << row : 0u;
    if (left == 0u) return;
    do push(p + ivec2(0, findLSB(left))); while ((left &= left - 1u) != 0u);
}
