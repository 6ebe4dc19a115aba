// The 32-bit key that orders by depth what lands in one shown pixel: nearer is larger.
//
// A key holds the shown inverse depth as a float32 with all 24 bits of its significand, for depths
// from 0.5 mm to 1000 km (31 exponents), and below them four bits that tell neighbours apart: (row
// mod 4, column mod 4) of the rendered pixel, the lower wins. So pixels of one surface, which often
// have exactly the same depth, do not tie. Farther pixels are ordered by the index of the rendered
// pixel alone, the lower wins; nearer ones count as 0.5 mm. 0 = nothing landed here.
const uint NEAREST_BITS = 0x44FFFFFFu;  // the largest float32 below 2^11 1/m
const uint FARTHEST_BITS = 0x35800000u; // 2^-20 1/m
const uint FAR_KEYS = 0x08000000u;      // keys below this one are beyond that distance

// source: index of the rendered pixel in the rendered picture, at most 2^27 - 2.
uint depth_key(float inverse_depth, ivec2 rendered, uint source) {
    uint bits = min(floatBitsToUint(abs(inverse_depth)), NEAREST_BITS); // abs: -0 is 0
    uint neighbour = 15u - (uint(rendered.y & 3) * 4u + uint(rendered.x & 3));
    return bits < FARTHEST_BITS ? FAR_KEYS - 1u - source : FAR_KEYS + (bits - FARTHEST_BITS) * 16u + neighbour;
}
