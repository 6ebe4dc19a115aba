// Makes one level of the pyramid from the one below, or (FROM_PICTURE 1) the first one from the shown picture.
// In: colour and weight, inverse depth in 1/m and share of empty pixels of the level below. Out: the same, of half the size.
// Source: Gortler et al. 1996, The Lumigraph, section 3.4 (push-pull); that only the farthest counts is this project's.
#if FROM_PICTURE
#define ROWS 4 // of a piece
#include "lib/holes.glsl"
layout(local_size_x = 64) in;
#else
#define ROWS 4
#include "lib/rows.glsl"
#endif
#include "lib/push_pull.glsl"
layout(rgba16f) readonly uniform image2D below_colour;
layout(rgba16f) writeonly uniform image2D level_colour;
layout(rg32f) writeonly uniform image2D level_depth;
uniform ivec2 below_size, level_size;
const vec4 KERNEL = vec4(0.125, 0.375, 0.375, 0.125);
const float GAIN = 4.0;               // so that one full texel of four makes a full one
const float LEAST = 1.0 / 1024.0;     // no weight vanishes in a half float, however many levels it passes

#if FROM_PICTURE
layout(r32f) readonly uniform image2D below_depth;
const float CRACKS = 1.0 / 1048576.0;

Texel below(ivec2 p) {
    vec4 colour = imageLoad(below_colour, p);
    return Texel(colour.rgb, colour.a, or_nearest(imageLoad(below_depth, p).r), colour.a > 0.0 ? 0.0 : 1.0);
}
#else
layout(rg32f) readonly uniform image2D below_depth;

Texel below(ivec2 p) {
    vec4 colour = imageLoad(below_colour, p);
    vec2 depth = imageLoad(below_depth, p).rg;
    return Texel(colour.rgb, colour.a, or_nearest(depth.r), depth.g);
}
#endif

// Of the 4 x 4 texels below that a texel reaches over. The first pass over them finds the farthest, the second sums.
void pull(ivec2 texel) {
    float farthest = UNKNOWN, holes = 0.0, inside = 0.0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            ivec2 p = 2 * texel - 1 + ivec2(x, y);
            float share = KERNEL[x] * KERNEL[y];
            Texel one = below(p);
            bool is_inside = all(lessThan(uvec2(p), uvec2(below_size)));
            inside += is_inside ? share : 0.0;
            holes += is_inside ? share * one.holes : 0.0;
            farthest = is_inside && one.weight > 0.0 ? min(farthest, one.depth) : farthest;
        }
    Sum sum = Sum(vec3(0.0), 0.0, 0.0);
    bool pending = holes > 0.0;
    while (pending) {
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x) add(sum, below(2 * texel - 1 + ivec2(x, y)), KERNEL[x] * KERNEL[y], farthest);
        pending = false;
    }
    float weight = sum.weight > 0.0 ? clamp(GAIN * sum.weight, LEAST, 1.0) : 0.0;
    float over = sum.weight > 0.0 ? 1.0 / sum.weight : 0.0;
    imageStore(level_colour, texel, vec4(sum.colour * over, weight));
#if FROM_PICTURE
    // Cracks are no holes that anything could hide in: of those only that they are there is told on.
    holes = holes > 0.0 && weight > 0.0 ? CRACKS : holes;
#endif
    imageStore(level_depth, texel, vec4(as_stored(weight > 0.0 ? sum.depth * over : UNKNOWN), holes / inside, 0.0, 0.0));
}

#if FROM_PICTURE
// The texels that reach over a piece: 6 x 4. Neighbouring pieces share some, and make the same of them.
ivec2 first_texel() {
    uint index = gl_GlobalInvocationID.x / uint(PIECE_WIDE), lane = gl_GlobalInvocationID.x % uint(PIECE_WIDE);
    return index < piece_count && lane < 6u ? first_of_piece(int(pieces[index])) / 2 + ivec2(lane, 0) - 1 : level_size;
}
#else
ivec2 first_texel() {
    return first_pixel();
}
#endif

void main() {
    ivec2 texel = first_texel();
    if (texel.x >= level_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++texel.y) {
        bool pending = all(lessThan(uvec2(texel), uvec2(level_size)));
        while (pending) {
            pull(texel);
            pending = false;
        }
    }
}
