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
uniform uint stamp; // unique to each run
const uint PIECES_OF_GROUP = uint(GROUP_X / PIECE_WIDE);
#if COARSE
// The same for the picture at half the resolution: the pieces with texels that have a hole below
// them or below those beside them.
layout(std430, binding = 2) buffer CoarsePieces { uint coarse_groups[3]; uint coarse_count; uint coarse_pieces[]; };
layout(std430, binding = 3) buffer CoarseStamps { uint coarse_stamp_of[]; };

// first, last: the texels that see an invocation's holes. At most four pieces, as these span less
// than one.
void list_coarse(ivec2 first, ivec2 last) {
    ivec2 most = (shown_size + 1) / 2 - 1, from = max(first, ivec2(0)) / ivec2(PIECE_WIDE, PIECE_HIGH);
    ivec2 to = min(last, most) / ivec2(PIECE_WIDE, PIECE_HIGH);
    int wide = most.x / PIECE_WIDE + 1;
    for (ivec2 at = from; at.y <= to.y; at = at.x < to.x ? at + ivec2(1, 0) : ivec2(from.x, at.y + 1)) {
        int piece = at.y * wide + at.x;
        if (atomicExchange(coarse_stamp_of[piece], stamp) == stamp) continue;
        uint slot = atomicAdd(coarse_count, 1u);
        coarse_pieces[slot] = uint(piece);
        if (slot % PIECES_OF_GROUP == 0u) atomicAdd(coarse_groups[0], 1u);
    }
}
#endif

void list_piece(int piece) {
    if (atomicExchange(stamp_of[piece].x, stamp) == stamp) return;
    uint slot = atomicAdd(piece_count, 1u);
    pieces[slot] = uint(piece);
    if (slot % PIECES_OF_GROUP == 0u) atomicAdd(piece_groups[0], 1u);
}

void main() {
    ivec2 p = first_pixel(), size = shown_size;
    if (p.x >= size.x) return;
    ivec2 first = p;
    uint holes = 0u;
    bool covered = false;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        vec4 colour = imageLoad(warped, p);
        imageStore(filled, p, colour);
#if WITH_DEPTH
        imageStore(filled_depth, p, imageLoad(warped_depth, p));
#endif
        holes |= colour.a == 0.0 ? 1u << row : 0u;
        covered = covered || colour.a > 0.0;
    }
    int piece = piece_of(first);
    if (covered) stamp_of[piece].y = stamp;
    // llvmpipe runs the body of an `if` for all invocations if any needs it, that of a loop for none
    // if none does.
    for (; holes != 0u; holes = 0u) {
        list_piece(piece);
#if COARSE
        list_coarse((first + ivec2(-1, findLSB(holes) - 1)) >> 1, (first + ivec2(1, findMSB(holes) + 1)) >> 1);
#endif
    }
}
