// Compute one level of the pyramid from the one below, or (FROM_PICTURE 1) the first one from the
// shown picture.
// In: colour and weight, inverse depth in 1/m and share of empty pixels of the level below. Out:
// the same, of half the size.
// Source: Gortler et al. 1996, The Lumigraph, section 3.4 (push-pull); the restriction to the
// farthest surface is this project's.
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
layout(rgba32f) writeonly uniform image2D level_depth;
uniform ivec2 below_size, level_size;
const vec4 KERNEL = vec4(0.125, 0.375, 0.375, 0.125);
const float GAIN = 4.0;               // so that one full texel of four makes a full one
const float LEAST = 1.0 / 1024.0;     // keeps weights from vanishing in half floats, however many levels they pass

#if FROM_PICTURE
layout(r32f) readonly uniform image2D below_depth;
const float CRACKS = 1.0 / 1048576.0;

Texel below(ivec2 p) {
    vec4 colour = imageLoad(below_colour, p);
    return Texel(colour.rgb, colour.a, or_nearest(imageLoad(below_depth, p).r), colour.a > 0.0 ? 0.0 : 1.0, colour.a);
}
#else
layout(rgba32f) readonly uniform image2D below_depth;

Texel below(ivec2 p) {
    vec4 colour = imageLoad(below_colour, p);
    vec3 depth = imageLoad(below_depth, p).rgb;
    return Texel(colour.rgb, colour.a, or_nearest(depth.r), depth.g, depth.b);
}
#endif

Texel found[16]; // the 4 x 4 below, row by row
uint is_inside[16]; // 0 or 1: Mesa's Zink makes no pipeline of an array of bool

// The upper half of one texel is the lower half of the next one in the column, so it is read once.
void read_two_rows(int first, ivec2 from) {
    for (int k = 0; k < 8; ++k) {
        ivec2 p = from + ivec2(k % 4, k / 4);
        found[first + k] = below(p);
        is_inside[first + k] = uint(all(lessThan(uvec2(p), uvec2(below_size))));
    }
}

#if !FROM_PICTURE
// Weight of a crack's border: next to nothing; applied at the second level
uniform float crack_border;
const float DEEP = 1.0 / 128.0;

// The farthest of the sixteen that is not an outlier.
float farthest_of_enough() {
    vec4 depths[4], borders[4];
    float all = 0.0, farthest = UNKNOWN;
    for (int row = 0; row < 4; ++row) {
        for (int x = 0; x < 4; ++x) {
            Texel one = found[4 * row + x];
            depths[row][x] = one.depth;
            borders[row][x] = one.weight > 0.0 ? KERNEL[row] * KERNEL[x] * one.border : 0.0;
        }
        all += dot(borders[row], vec4(1.0));
    }
    for (int k = 0; k < 16; ++k) {
        float depth = depths[k / 4][k % 4], beside = 0.0;
        for (int row = 0; row < 4; ++row) beside += border_beside(depths[row], borders[row], depth);
        farthest = borders[k / 4][k % 4] > 0.0 && is_enough(beside, all) ? min(farthest, depth) : farthest;
    }
    return farthest;
}
#endif

// Of the 4 x 4 texels below that a texel spans: the farthest surface.
void pull(ivec2 texel) {
    float farthest = UNKNOWN, holes = 0.0, inside = 0.0;
    for (int k = 0; k < 16; ++k) {
        float share = is_inside[k] != 0u ? KERNEL[k % 4] * KERNEL[k / 4] : 0.0;
        inside += share;
        holes += share * found[k].holes;
#if FROM_PICTURE
        farthest = found[k].weight > 0.0 ? min(farthest, found[k].depth) : farthest;
#endif
    }
#if !FROM_PICTURE
    farthest = farthest_of_enough();
#endif
    Sum sum = NOTHING;
    for (int k = 0; k < 16; ++k) add(sum, found[k], holes > 0.0 ? KERNEL[k % 4] * KERNEL[k / 4] : 0.0, farthest);
    float weight = sum.weight > 0.0 ? clamp(GAIN * sum.weight, LEAST, 1.0) : 0.0;
    float over = sum.weight > 0.0 ? 1.0 / sum.weight : 0.0;
    imageStore(level_colour, texel, vec4(sum.colour * over, weight));
#if FROM_PICTURE
    // Cracks hide nothing: the next level only records that they exist.
    holes = holes > 0.0 && weight > 0.0 ? CRACKS : holes;
#else
    sum.border *= holes >= DEEP * inside ? 1.0 : crack_border;
#endif
    imageStore(level_depth, texel, vec4(as_stored(weight > 0.0 ? sum.depth * over : UNKNOWN), holes / inside, sum.border, 0.0));
}

#if FROM_PICTURE
// The texels that span a piece: 6 x 4. Neighbouring pieces share some, and compute the same values.
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
    read_two_rows(8, 2 * texel - 1);
    for (int row = 0; row < ROWS; ++row, ++texel.y) {
        if (texel.y >= level_size.y) break;
        for (int k = 0; k < 8; ++k) {
            found[k] = found[k + 8];
            is_inside[k] = is_inside[k + 8];
        }
        read_two_rows(8, 2 * texel + ivec2(-1, 1));
        if (texel.x >= 0 && texel.y >= 0) pull(texel);
    }
}
