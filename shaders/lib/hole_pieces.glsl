// The pieces of the shown picture, 8 x ROWS pixels each, that have holes. Fills from pictures run
// on them, by an indirect dispatch whose group counts come first. lib/composite.glsl does the same
// for warps.
#include "lib/rows.glsl"
const int PIECE = 8; // as many invocations as llvmpipe runs at a time
// x: index; y: stamp when it was listed
layout(std430, binding = 1) buffer Pieces { uint piece_groups[3]; uint piece_count; uvec2 pieces[]; };
uniform ivec2 shown_size;

int pieces_in_a_row() {
    return (shown_size.x + PIECE - 1) / PIECE;
}
