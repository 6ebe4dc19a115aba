// Copy the shown picture to the filled one, and list its pieces that have holes.
// In: shown colour (and inverse depth). Out: the same; the list of lib/holes.glsl; for each piece,
// when it last had a covered pixel.
// Source: none; stream compaction by atomics, as in lib/composite.glsl.
#define ROWS 4 // PIECE_HIGH
#include "lib/rows.glsl"
#include "lib/holes.glsl"
// For each piece: when it last had a hole (x), and a covered pixel (y)
layout(std430, binding = 1) buffer Stamps { uvec2 stamp_of[]; };
layout(rgba16f) readonly uniform image2D warped;
layout(rgba16f) writeonly uniform image2D filled;
#if WITH_DEPTH
layout(r32f) readonly uniform image2D warped_depth;
layout(r32f) writeonly uniform image2D filled_depth;
#endif
#if TWICE
layout(rgba16f) writeonly uniform image2D filled_too;
#endif
uniform uint stamp; // unique to each run

void list_piece(int piece) {
    if (atomicExchange(stamp_of[piece].x, stamp) == stamp) return;
    uint slot = atomicAdd(piece_count, 1u);
    pieces[slot] = uint(piece);
    atomicMax(piece_groups[0], slot * uint(PIECE_WIDE) / uint(GROUP_X) + 1u);
}

void main() {
    ivec2 p = first_pixel(), size = shown_size;
    if (p.x >= size.x) return;
    int piece = piece_of(p);
    bool hole = false, covered = false;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        vec4 colour = imageLoad(warped, p);
        imageStore(filled, p, colour);
#if TWICE
        imageStore(filled_too, p, colour);
#endif
#if WITH_DEPTH
        imageStore(filled_depth, p, imageLoad(warped_depth, p));
#endif
        hole = hole || colour.a == 0.0;
        covered = covered || colour.a > 0.0;
    }
    if (covered) stamp_of[piece].y = stamp;
    if (hole) list_piece(piece);
}
