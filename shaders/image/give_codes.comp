// Makes what the feed sends in half of the bytes: sRGB with coverage, inverse depth in 16 bits.
// In: rgba16f as its bits; r32f in 1/m. Out: the pictures' rows, the top one first, each filled up
// to 2 pixels. STEP is 0 for a pass that finds the nearest surface, 1 for the one that writes.
// Source: docs/feed.md (colour 2, depth 5).
#define ROWS 4
#include "lib/rows.glsl"
layout(rg32ui, binding = 0) readonly uniform uimage2D rendered_colour;
layout(r32f, binding = 1) readonly uniform image2D inverse_depth;
layout(r8ui, binding = 2) readonly uniform uimage2D byte_of_half; // 256x256
layout(std430, binding = 0) buffer Nearest { uint nearest; };    // bits of 1/m, which are in its order
layout(std430, binding = 1) writeonly buffer Colours { uint colours[]; };
layout(std430, binding = 2) writeonly buffer Codes { uint codes[]; };
uniform ivec2 rendered_size;

const float LARGEST = 65534.0;
const uint NONE = 65535u;

bool is_known(float inverse) { return inverse >= 0.0 && !isinf(inverse); }

#if STEP == 1
uint byte_of(uint bits) {
    return imageLoad(byte_of_half, ivec2(bits & 0xffu, bits >> 8)).r;
}

uint colour_of(uvec2 halves) {
    uint rgb = byte_of(halves.x & 0xffffu) | byte_of(halves.x >> 16) << 8 | byte_of(halves.y & 0xffffu) << 16;
    return unpackHalf2x16(halves.y).y > 0.0 ? rgb | 0xff000000u : rgb;
}

// What is not infinitely far stays so.
uint code_of(float inverse, float unit) {
    if (!is_known(inverse)) return NONE;
    return inverse == 0.0 ? 0u : uint(clamp(floor(inverse / unit + 0.5), 1.0, LARGEST));
}
#endif

void main() {
    ivec2 q = first_pixel();
    int pairs = (rendered_size.x + 1) >> 1;
    if (q.x >= pairs) return;
    float most = 0.0;
    for (int row = 0; row < ROWS; ++row, ++q.y) {
        if (q.y >= rendered_size.y) break;
        uint both = 0u;
        for (int k = 0; k < 2; ++k) {
            ivec2 p = ivec2(2 * q.x + k, q.y); // beyond the picture all is 0
            float inverse = imageLoad(inverse_depth, p).r;
#if STEP == 0
            if (is_known(inverse)) most = max(most, inverse);
#else
            int pair = (rendered_size.y - 1 - q.y) * pairs + q.x;
            colours[2 * pair + k] = colour_of(imageLoad(rendered_colour, p).rg);
            both |= code_of(inverse, uintBitsToFloat(nearest) / LARGEST) << (16 * k);
            codes[pair] = both;
#endif
        }
    }
#if STEP == 0
    if (most > 0.0) atomicMax(nearest, floatBitsToUint(most));
#endif
}
