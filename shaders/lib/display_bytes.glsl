// What a display shows of linear light, in whole bytes of sRGB: by a table of all halves, so that
// it is to the last bit what files, windows and measurements get.
layout(std430, binding = 2) readonly buffer DisplayBytes { uint four_bytes[16384]; };

// light: read from rgba16f.
float byte_of(float light) {
    uint index = packHalf2x16(vec2(light, 0.0)) & 0xffffu;
    return float((four_bytes[index >> 2] >> ((index & 3u) * 8u)) & 0xffu);
}

vec3 bytes_of(vec3 light) {
    return vec3(byte_of(light.r), byte_of(light.g), byte_of(light.b));
}

vec3 light_of(vec3 encoded) {
    vec3 low = encoded / 12.92, high = pow((encoded + 0.055) / 1.055, vec3(2.4));
    return mix(high, low, lessThanEqual(encoded, vec3(0.04045)));
}

vec3 encoded_of(vec3 light) {
    vec3 low = light * 12.92, high = 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055;
    return mix(high, low, lessThanEqual(light, vec3(0.0031308)));
}
