// Where one drawn pixel lands in the shown picture, and the key that orders what lands there: nearer is larger.
//
// A key holds the shown inverse depth as a float32 with all 24 bits of its significand, for depths from 0.5 mm to 1000 km
// (31 exponents), and below them four bits that tell neighbours apart: (row mod 4, column mod 4) of the drawn pixel, the
// lower wins. So pixels of one surface, which often have the very same depth, do not tie. What is farther is ordered by
// the index of the drawn pixel alone, the lower wins; what is nearer counts as 0.5 mm. 0 = nothing landed here.
layout(r32f) readonly uniform image2D late_inverse_depth;
uniform ivec2 late_size;
uniform ivec2 shown_size;

const uint NEAREST_BITS = 0x44FFFFFFu;  // the largest float32 below 2^11 1/m
const uint FARTHEST_BITS = 0x35800000u; // 2^-20 1/m
const uint FAR_KEYS = 0x08000000u;      // keys below this one are farther than that

uint depth_key(float inverse_depth, ivec2 drawn, uint source) {
    uint bits = min(floatBitsToUint(inverse_depth), NEAREST_BITS);
    uint neighbour = 15u - (uint(drawn.y & 3) * 4u + uint(drawn.x & 3));
    return bits < FARTHEST_BITS ? FAR_KEYS - 1u - source : FAR_KEYS + (bits - FARTHEST_BITS) * 16u + neighbour;
}

struct Landing {
    bool lands;
    ivec2 pixel;
    uint slot;   // index of the pixel in the shown picture
    uint source; // index of the drawn pixel in the late picture, at most 2^27 - 2
    uint key;
};

Landing landing(ivec2 drawn, vec3 base) {
    float inverse_depth = imageLoad(late_inverse_depth, drawn).r;
    // precise: two passes must compute the same bits, whatever the compiler would contract.
    precise vec3 q = base + e * inverse_depth;
    precise vec2 p = q.xy / q.z;
    precise float shown_inverse_depth = inverse_depth / q.z;
    Landing to;
    to.lands = inverse_depth >= 0.0 && q.z > 0.0 && inside(p, shown_size);
    to.pixel = ivec2(p);
    to.slot = uint(to.pixel.y) * uint(shown_size.x) + uint(to.pixel.x);
    to.source = uint(drawn.y) * uint(late_size.x) + uint(drawn.x);
    to.key = depth_key(shown_inverse_depth, drawn, to.source);
    return to;
}

// A drawn pixel that finds its own key there sets tie_groups.z to 1, the z of the indirect dispatches that settle ties.
layout(std430, binding = 0) buffer Keys { uint key_of[]; };
layout(std430, binding = 1) buffer Ties { uint tie_groups[3]; uint spare; uint winner_of[]; };
const uint NO_WINNER = 0xFFFFFFFFu;
