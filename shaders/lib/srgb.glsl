// Linear light from sRGB and back, both 0 to 1.
// Source: IEC 61966-2-1:1999 with its amendment 1.

vec3 light_of(vec3 encoded) {
    vec3 low = encoded / 12.92, high = pow((encoded + 0.055) / 1.055, vec3(2.4));
    return mix(high, low, lessThanEqual(encoded, vec3(0.04045)));
}

vec3 encoded_of(vec3 light) {
    vec3 low = light * 12.92, high = 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055;
    return mix(high, low, lessThanEqual(light, vec3(0.0031308)));
}
