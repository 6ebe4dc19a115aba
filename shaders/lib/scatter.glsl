// Where one drawn pixel lands in the shown picture, and the key that orders what lands there: nearer is larger.
// The key is the bit pattern of the shown inverse depth (non-negative floats sort as integers), 0 = nothing landed here.
// Everything infinitely far would tie; there the key is a denormal number, no real inverse depth, that falls with the index
// of the drawn pixel, so that the lowest index wins as everywhere else.
uniform sampler2D late_inverse_depth;
uniform ivec2 late_size;
uniform ivec2 shown_size;

const uint SMALLEST_NORMAL = 0x00800000u; // the bits of 2^-126

struct Landing {
    bool lands;
    ivec2 pixel;
    uint slot;   // index of the pixel in the shown picture
    uint source; // index of the drawn pixel in the late picture
    uint key;
};

Landing landing(ivec2 drawn, vec3 base) {
    float inverse_depth = texelFetch(late_inverse_depth, drawn, 0).r;
    // precise: two passes must compute the same bits, whatever the compiler would contract.
    precise vec3 q = base + e * inverse_depth;
    precise vec2 p = q.xy / q.z;
    precise float shown_inverse_depth = inverse_depth / q.z;
    Landing to;
    to.lands = inverse_depth >= 0.0 && q.z > 0.0 && inside(p, shown_size);
    to.pixel = ivec2(p);
    to.slot = uint(to.pixel.y) * uint(shown_size.x) + uint(to.pixel.x);
    to.source = uint(drawn.y) * uint(late_size.x) + uint(drawn.x);
    uint bits = floatBitsToUint(shown_inverse_depth);
    to.key = bits < SMALLEST_NORMAL ? SMALLEST_NORMAL - 1u - (to.source & (SMALLEST_NORMAL - 1u)) : bits;
    to.key += 1u;
    return to;
}

// A drawn pixel that finds its own key there sets tie_groups.z to 1, the z of the indirect dispatches that settle ties.
layout(std430, binding = 0) buffer Keys { uint key_of[]; };
layout(std430, binding = 1) buffer Ties { uint tie_groups[3]; uint spare; uint winner_of[]; };
const uint NO_WINNER = 0xFFFFFFFFu;
