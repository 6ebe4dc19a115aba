// First guesses of a gather: for each cell of shown pixels the inverse depth, in the rendered
// picture, of the front surface.
//
// The search gives each cell a key: the rendered inverse depth in its upper bits, 5 of them
// for the exponent (2^-20 to 2^11 1/m, clamped), and the rendered texel (y, x) in its lower
// index_bits. The larger key wins. 0 = nothing lands here.
#define BLOCK 4
layout(std430, binding = 0) buffer Seeds { uint seed_of[]; };
uniform ivec2 cells;

float seed_at(vec2 shown) {
    ivec2 cell = clamp(ivec2(shown * (1.0 / float(BLOCK))), ivec2(0), cells - 1);
    return uintBitsToFloat(seed_of[cell.y * cells.x + cell.x]);
}
