// The nearest inverse depth that lands in each shown pixel, as the bits of a float32 plus one: the
// bits of floats >= 0 sort like the floats. 0: nothing landed.
layout(std430, binding = 0) buffer Seeds { uint seed_of[]; };

uint seed_key(float inverse_depth) {
    return floatBitsToUint(abs(inverse_depth)) + 1u; // abs: -0 is 0
}

// -1 for nothing.
float seed_depth(uint key) {
    return key == 0u ? -1.0 : uintBitsToFloat(key - 1u);
}
