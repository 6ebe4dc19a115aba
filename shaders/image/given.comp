// Takes somebody else's colour and depth over: linear light with coverage, and inverse depth.
// In: given_colour (linear light or sRGB, coverage in alpha), given_depth. Out: rgba16f, r32f.
// Source: IEC 61966-2-1 (sRGB); OpenXR 1.1, XrCompositionLayerDepthInfoKHR (depth buffers).
#include "lib/rows.glsl"
#if ENCODED
#include "lib/srgb.glsl"
#endif
uniform sampler2D given_colour;
uniform sampler2D given_depth;
layout(rgba16f) writeonly uniform image2D colour;
layout(r32f) writeonly uniform image2D inverse_depth;
uniform ivec2 rendered_size;
#if DEPTH == 2
// inverse depth = at_least + per_value * (value - low); beyond low - slack and high + slack is none.
uniform float low, high, slack, at_least, per_value;
#endif

const float NONE = -1.0;
const float LARGEST = 65504.0;  // of a half

vec3 taken_over(vec3 value) {
#if ENCODED
    return light_of(clamp(value, 0.0, 1.0));
#else
    return clamp(value, -LARGEST, LARGEST);
#endif
}

float inverse_of(float value) {
#if DEPTH == 0
    // Inverse depth as it is; below 0 and NaN is none.
    return value >= 0.0 ? value : NONE;
#elif DEPTH == 1
    // Metres: 0, below 0 and NaN is none. Division by infinity need not be 0 in GLSL.
    return value > 0.0 ? (isinf(value) ? 0.0 : 1.0 / value) : NONE;
#else
    if (!(value >= low - slack && value <= high + slack)) return NONE;
    return at_least + per_value * (clamp(value, low, high) - low);
#endif
}

void main() {
    ivec2 p = first_pixel();
    if (p.x >= rendered_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= rendered_size.y) break;
        vec4 given = texelFetch(given_colour, p, 0);
        float inverse = inverse_of(texelFetch(given_depth, p, 0).r);
        bool covered = given.a > 0.0 && inverse >= 0.0;
        imageStore(colour, p, covered ? vec4(taken_over(given.rgb), 1.0) : vec4(0.0));
        imageStore(inverse_depth, p, vec4(covered ? inverse : NONE, 0.0, 0.0, 0.0));
    }
}
