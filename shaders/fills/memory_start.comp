// Start a fill from pictures with depth: copy the shown picture, and list its pieces that have
// holes.
// In: shown colour and inverse depth. Out: the same in the filled picture; the list of
// lib/hole_pieces.glsl.
// Source: lib/composite.glsl, which lists pieces in the same way for warps.
#define ROWS 4
#include "lib/hole_pieces.glsl"
layout(rgba16f) readonly uniform image2D shown_colour;
layout(rgba16f) writeonly uniform image2D filled_colour;
// 1 x 1 where no pass reads depth: outside it loads return 0 and stores are dropped
layout(r32f) readonly uniform image2D shown_depth;
layout(r32f) writeonly uniform image2D filled_depth;
uniform uint stamp; // unique to each run

void list_piece(ivec2 first) {
    uint piece = uint(first.y / ROWS * pieces_in_a_row() + first.x / PIECE);
    if (atomicExchange(pieces[piece].y, stamp) == stamp) return;
    uint slot = atomicAdd(piece_count, 1u);
    pieces[slot].x = piece;
    if (slot % uint(GROUP_X / PIECE) == 0u) atomicAdd(piece_groups[0], 1u);
}

void main() {
    ivec2 first = first_pixel(), size = shown_size;
    if (first.x >= size.x) return;
    bool has_hole = false;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 p = first + ivec2(0, row);
        if (p.y >= size.y) break;
        vec4 colour = imageLoad(shown_colour, p);
        imageStore(filled_colour, p, colour);
        imageStore(filled_depth, p, imageLoad(shown_depth, p));
        has_hole = has_hole || colour.a == 0.0;
    }
    if (has_hole) list_piece(first);
}
