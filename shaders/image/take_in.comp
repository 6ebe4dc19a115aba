// Takes a caller's arrays over: linear light with coverage, and inverse depth; notes what is wrong.
// In: the arrays' bytes, 16 to a texel, top row first. Out: rgba16f as its bits; r32f in 1/m.
// SCALED: sRGB bytes alone, without coverage, to another size. A pixel has the mean of the linear
// light of the pixels with their centres in it, and the depth of the one at its own centre, as no
// surface has the mean of two depths; both are none where the lens hides it.
// Source: IEC 61966-2-1 (sRGB); half floats of IEEE 754-2019, rounded to even as NumPy does.
// As images, because llvmpipe reads a word of a buffer in 9 ns and 4 of an image in 2 ns.
#define ROWS 4
#include "lib/rows.glsl"
#if ENCODED
#include "lib/srgb.glsl"
#endif
// DEPTH is 0 for inverse depth, 1 for floats in units, 2 for 16-bit integers in units, 3 for such
// of inverse depth. APART: colour without depth stays, and depth without colour.
// Bindings are written here: moderngl sets no uniform of the type uimage2D.
layout(rg32ui, binding = 0) writeonly uniform uimage2D colour;
layout(r32f, binding = 1) writeonly uniform image2D inverse_depth;
layout(rgba32ui, binding = 2) readonly uniform uimage2D given_colour;
layout(rgba32ui, binding = 3) readonly uniform uimage2D given_depth;
layout(std430, binding = 0) buffer Found { uint found[]; };
#if SCALED
layout(r32f, binding = 4) readonly uniform image2D light_of_byte;
// Of each column (upper row), and of each row from the top: first pixel and, in the upper half, the
// one after the last; where depth is; for columns the seen rows from z up to w.
layout(rgba32ui, binding = 5) readonly uniform uimage2D spans;
#else
layout(r16ui, binding = 4) readonly uniform uimage2D light_of_byte; // the bits of halves
#endif
uniform ivec2 rendered_size;
uniform float scale; // metres, or 1/m, per unit of depth
uniform int slot;    // of `found`, in words

// In one texel for each channel there are PIXELS pixels.
#define PIXELS (16 / ITEM_BYTES)
// Words of `found`, as in hmdwarp/image/array_passes.py.
const int WRONG = 0, NEGATIVE = 1, POSITIVE = 2, LARGEST = 3, BRIGHT = 4, FRACTION = 5, ABOVE_ONE = 6, WORDS = 7;
const float NONE = -1.0;
const float MOST = 65504.0; // of a half
const float BRIGHTEST = 64.0;
const uint ONE = 0x3c00u;

uint item(uint words[4 * CHANNELS], int n) {
#if ITEM_BYTES == 1
    return (words[n >> 2] >> ((n & 3) * 8)) & 0xffu;
#elif ITEM_BYTES == 2
    return (words[n >> 1] >> ((n & 1) * 16)) & 0xffffu;
#else
    return words[n];
#endif
}

float number_of(uint bits) {
#if ITEM_BYTES == 2
    return unpackHalf2x16(bits).x;
#else
    return uintBitsToFloat(bits);
#endif
}

bool is_finite(uint bits) {
    const uint EXPONENT = ITEM_BYTES == 2 ? 0x7c00u : 0x7f800000u;
    return (bits & EXPONENT) != EXPONENT;
}

// packHalf2x16 need not round to the nearest.
uint half_of(float value) {
    uint bits = floatBitsToUint(value), sign = (bits >> 16) & 0x8000u;
    bits &= 0x7fffffffu;
    uint normal = (bits + 0xfffu + ((bits >> 13) & 1u) - 0x38000000u) >> 13;
    return sign | (bits < 0x38800000u ? uint(roundEven(abs(value) * 16777216.0)) : normal);
}

vec4 depths_of(ivec2 quad) {
#if DEPTH >= 2
    uvec4 all = imageLoad(given_depth, ivec2(quad.x >> 1, quad.y));
    uvec2 words = (quad.x & 1) == 0 ? all.xy : all.zw;
    return vec4(words.x & 0xffffu, words.x >> 16, words.y & 0xffffu, words.y >> 16);
#else
    return uintBitsToFloat(imageLoad(given_depth, quad));
#endif
}

float inverse_of(float value) {
#if DEPTH == 0
    return value >= 0.0 ? value : NONE;
#elif DEPTH == 3
    return value == 65535.0 ? NONE : value * scale;
#else
    float metres = value * scale;
    // Division by infinity need not be 0 in GLSL.
    float inverse = metres > 0.0 && !(DEPTH == 2 && value == 65535.0) ? (isinf(metres) ? 0.0 : 1.0 / metres) : NONE;
    return isinf(inverse) ? NONE : inverse;
#endif
}

#if SCALED
uint byte_at(int n, int row) {
    return (imageLoad(given_colour, ivec2(n >> 4, row))[(n >> 2) & 3] >> ((n & 3) * 8)) & 0xffu;
}

vec3 light_at(ivec2 p) {
    vec3 light;
    for (int c = 0; c < 3; ++c) light[c] = imageLoad(light_of_byte, ivec2(byte_at(3 * p.x + c, p.y), 0)).r;
    return light;
}

void main() {
    ivec2 p = first_pixel();
    if (p.x >= rendered_size.x) return;
    ivec4 column = ivec4(imageLoad(spans, ivec2(p.x, 0)));
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= rendered_size.y) break;
        ivec2 line = ivec2(imageLoad(spans, ivec2(rendered_size.y - 1 - p.y, 1)).xy);
        ivec2 from = ivec2(column.x, line.x) & 0xffff, end = ivec2(column.x, line.x) >> 16;
        vec3 sum = vec3(0.0);
        for (int y = from.y; y < end.y; ++y)
            for (int x = from.x; x < end.x; ++x) sum += light_at(ivec2(x, y));
        vec3 mean = sum / float((end.x - from.x) * (end.y - from.y));
        float inverse = inverse_of(depths_of(ivec2(column.y >> 2, line.y))[column.y & 3]);
        bool seen = p.y >= column.z && p.y < column.w;
        uvec3 light = uvec3(half_of(mean.r), half_of(mean.g), half_of(mean.b));
        imageStore(colour, p, seen ? uvec4(light.r | light.g << 16, light.b | ONE << 16, 0u, 0u) : uvec4(0u));
        imageStore(inverse_depth, p, vec4(seen ? inverse : NONE, 0.0, 0.0, 0.0));
    }
}
#else
void main() {
    ivec2 q = first_pixel();
    if (q.x * PIXELS >= rendered_size.x) return;
    uint seen[WORDS] = uint[WORDS](0u, 0u, 0u, 0u, 0u, 0u, 0u);
    for (int row = 0; row < ROWS; ++row, ++q.y) {
        if (q.y >= rendered_size.y) break;
        int from = rendered_size.y - 1 - q.y;
        uint words[4 * CHANNELS];
        for (int n = 0; n < CHANNELS; ++n) {
            uvec4 texel = imageLoad(given_colour, ivec2(CHANNELS * q.x + n, from));
            for (int k = 0; k < 4; ++k) words[4 * n + k] = texel[k];
        }
        for (int quad = 0; quad < PIXELS / 4; ++quad) {
            vec4 values = depths_of(ivec2(q.x * (PIXELS / 4) + quad, from));
            for (int k = 0; k < 4; ++k) {
                ivec2 p = ivec2(q.x * PIXELS + 4 * quad + k, q.y);
                uint one = p.x < rendered_size.x ? 1u : 0u; // what fills up a row counts for nothing
                int first = CHANNELS * (4 * quad + k);
                bool hidden = false;
#if CHANNELS == 4
                uint alpha = item(words, first + 3);
#if ITEM_BYTES == 1
                hidden = alpha == 0u;
#else
                hidden = number_of(alpha) == 0.0;
                if (!is_finite(alpha) || number_of(alpha) < 0.0) seen[WRONG] |= one;
#endif
#endif
                float value = values[k];
                float inverse = inverse_of(value);
#if DEPTH == 2
                if (value == 65535.0) seen[LARGEST] |= one;
#endif
#if DEPTH == 1 || DEPTH == 2
                if (value * scale < 0.0) seen[NEGATIVE] |= one;
                if (inverse > 0.0 && !hidden) seen[POSITIVE] |= one;
#endif
                uvec3 light;
                for (int c = 0; c < 3; ++c) {
                    uint bits = item(words, first + c);
#if ITEM_BYTES == 1
                    light[c] = imageLoad(light_of_byte, ivec2(bits, 0)).r;
#else
                    if (hidden) bits = 0u;
                    float number = number_of(bits);
                    if (!is_finite(bits)) seen[WRONG] |= one;
#if ENCODED
                    if (number > 1.0) seen[WRONG] |= one;
                    light[c] = half_of(light_of(vec3(clamp(number, 0.0, 1.0))).r);
#else
#if GUESSED
                    if (number > BRIGHTEST) seen[BRIGHT] |= one;
                    if (number != round(number)) seen[FRACTION] |= one;
                    if (number > 1.0) seen[ABOVE_ONE] += one;
#endif
                    light[c] = ITEM_BYTES == 2 ? bits : half_of(clamp(number, -MOST, MOST));
#endif
#endif
                }
#if APART
                uint cover = hidden ? 0u : ONE;
                imageStore(colour, p, uvec4(light.r | light.g << 16, light.b | cover << 16, 0u, 0u));
                imageStore(inverse_depth, p, vec4(inverse, 0.0, 0.0, 0.0));
#else
                bool covered = inverse >= 0.0 && !hidden;
                imageStore(colour, p, covered ? uvec4(light.r | light.g << 16, light.b | ONE << 16, 0u, 0u) : uvec4(0u));
                imageStore(inverse_depth, p, vec4(covered ? inverse : NONE, 0.0, 0.0, 0.0));
#endif
            }
        }
    }
    // Plain stores: whoever writes, writes 1.
    for (int n = 0; n < ABOVE_ONE; ++n) {
        if (seen[n] != 0u) found[slot + n] = 1u;
    }
#if GUESSED
    if (seen[ABOVE_ONE] > 0u) atomicAdd(found[slot + ABOVE_ONE], seen[ABOVE_ONE]);
#endif
}
#endif
