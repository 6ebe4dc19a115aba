// The pieces of the shown picture, 8 x 4 pixels each, that have holes: passes that change holes
// only are dispatched over these. A piece is as wide as the number of invocations that llvmpipe
// runs at a time, so that none idles.
const int PIECE_WIDE = 8, PIECE_HIGH = 4;
layout(std430, binding = 0) buffer HolePieces { uint piece_groups[3]; uint piece_count; uint pieces[]; };
uniform ivec2 shown_size;

int pieces_in_a_row() {
    return (shown_size.x + PIECE_WIDE - 1) / PIECE_WIDE;
}

int piece_of(ivec2 pixel) {
    return pixel.y / PIECE_HIGH * pieces_in_a_row() + pixel.x / PIECE_WIDE;
}

ivec2 first_of_piece(int piece) {
    int wide = pieces_in_a_row();
    return ivec2(piece % wide * PIECE_WIDE, piece / wide * PIECE_HIGH);
}
