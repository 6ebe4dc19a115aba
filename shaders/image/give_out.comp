// Makes the arrays of a result: colour, coverage, depth in metres; counts the holes of the warp.
// In: rgba16f as its bits; r32f in 1/m. Out: the arrays' rows, the top one first, each filled up to
// 4 pixels.
// Source: IEC 61966-2-1 (sRGB); bytes by a table of all halves, as in lib/display_bytes.glsl.
#define ROWS 4
#include "lib/rows.glsl"
// RESULT is 0 for bytes of sRGB, 1 for floats of sRGB, 2 for linear light.
#if RESULT == 1
#include "lib/srgb.glsl"
#endif
layout(rg32ui, binding = 0) readonly uniform uimage2D shown;
layout(rg32ui, binding = 1) readonly uniform uimage2D warped;
layout(r32f, binding = 2) readonly uniform image2D inverse_depth;
layout(rgba16f, binding = 3) readonly uniform image2D confidence;
layout(r8ui, binding = 4) readonly uniform uimage2D byte_of_half; // 256x256
layout(std430, binding = 0) buffer Found { uint found[]; };
layout(std430, binding = 1) writeonly buffer Colours { uint colours[]; };
layout(std430, binding = 2) writeonly buffer Coverages { float coverages[]; };
layout(std430, binding = 3) writeonly buffer Depths { uint depths[]; };
uniform ivec2 shown_size;
uniform int slot; // of `found`, in words

const uint NOT_KNOWN = 0x7fc00000u, INFINITE = 0x7f800000u; // as bits of a float

#if RESULT == 0
uint byte_of(uint bits) {
    return imageLoad(byte_of_half, ivec2(bits & 0xffu, bits >> 8)).r;
}

uint pixel_of(uvec2 halves) {
    return byte_of(halves.x & 0xffffu) | byte_of(halves.x >> 16) << 8 | byte_of(halves.y & 0xffffu) << 16;
}
#else
vec3 pixel_of(uvec2 halves) {
    vec3 light = vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x);
#if RESULT == 1
    return encoded_of(mix(clamp(light, 0.0, 1.0), vec3(0.0), isnan(light)));
#else
    return light;
#endif
}
#endif

void main() {
    ivec2 q = first_pixel();
    int quads = (shown_size.x + 3) >> 2;
    if (q.x >= quads) return;
    uint holes = 0u;
    for (int row = 0; row < ROWS; ++row, ++q.y) {
        if (q.y >= shown_size.y) break;
        int quad = (shown_size.y - 1 - q.y) * quads + q.x;
#if RESULT == 0
        uint pixels[4];
#endif
        for (int k = 0; k < 4; ++k) {
            ivec2 p = ivec2(4 * q.x + k, q.y); // beyond the picture all is 0
            uvec2 halves = imageLoad(shown, p).rg;
            bool hole = (imageLoad(warped, p).g & 0x7fff0000u) == 0u;
            if (hole && p.x < shown_size.x) ++holes;
            float coverage = unpackHalf2x16(halves.y).y;
#if CONFIDENCE
            if (!hole) coverage = clamp(imageLoad(confidence, p).r, 0.0, 1.0);
#endif
            coverages[4 * quad + k] = coverage;
#if DEPTH
            float inverse = imageLoad(inverse_depth, p).r;
            depths[4 * quad + k] = inverse > 0.0 ? floatBitsToUint(1.0 / inverse) : inverse == 0.0 ? INFINITE : NOT_KNOWN;
#endif
#if RESULT == 0
            pixels[k] = pixel_of(halves);
#else
            vec3 pixel = pixel_of(halves);
            for (int c = 0; c < 3; ++c) colours[12 * quad + 3 * k + c] = floatBitsToUint(pixel[c]);
#endif
        }
#if RESULT == 0
        colours[3 * quad] = pixels[0] | pixels[1] << 24;
        colours[3 * quad + 1] = pixels[1] >> 8 | pixels[2] << 16;
        colours[3 * quad + 2] = pixels[2] >> 16 | pixels[3] << 8;
#endif
    }
    if (holes > 0u) atomicAdd(found[slot], holes);
}
