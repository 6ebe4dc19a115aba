// Which of two depths lies behind, for fills, which continue the background. Inverse depths in 1/m;
// -1 is unknown, and counts as nearer than everything known.
const float UNKNOWN = 1e30, MOST_KNOWN = 1e29; // means of unknown depths may round to less than UNKNOWN
// Inverse depths that differ by less than this times (the smaller one + floor) belong to one
// surface
uniform float depth_tolerance;
uniform float depth_floor;     // 1/m

float or_nearest(float inverse_depth) {
    return inverse_depth >= 0.0 && inverse_depth < MOST_KNOWN ? inverse_depth : UNKNOWN;
}

// The nearest depth that still counts as equally far.
float nearest_beside(float farthest) {
    return farthest + depth_tolerance * (farthest + depth_floor);
}

// 1 for depths as far as `farthest` or farther, falling smoothly to 0 for nearer ones: half at the
// tolerance, 1e-4 at ten times that.
float is_beside(float inverse_depth, float farthest) {
    float nearer = max(inverse_depth - farthest, 0.0) / (depth_tolerance * (farthest + depth_floor) + 1e-12), squared = nearer * nearer;
    return nearer < 100.0 ? 1.0 / (1.0 + squared * squared) : 0.0;
}

// The product of is_beside both ways, one of which is 1: how much the two are one surface.
vec4 are_same(vec4 ones, float other) {
    vec4 apart = abs(ones - other) / (depth_tolerance * (min(ones, vec4(other)) + depth_floor) + 1e-12), squared = apart * apart;
    return mix(vec4(0.0), 1.0 / (1.0 + squared * squared), lessThan(apart, vec4(100.0)));
}

float as_stored(float inverse_depth) {
    return inverse_depth < MOST_KNOWN ? inverse_depth : -1.0;
}
