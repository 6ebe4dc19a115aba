// What a display shows of linear light, in whole bytes of sRGB: by a table of all halves, so that
// it is to the last bit what files, windows and measurements get.
#include "lib/srgb.glsl"
layout(std430, binding = 2) readonly buffer DisplayBytes { uint four_bytes[16384]; };

// light: read from rgba16f.
float byte_of(float light) {
    uint index = packHalf2x16(vec2(light, 0.0)) & 0xffffu;
    return float((four_bytes[index >> 2] >> ((index & 3u) * 8u)) & 0xffu);
}

vec3 bytes_of(vec3 light) {
    return vec3(byte_of(light.r), byte_of(light.g), byte_of(light.b));
}
