// Run over the listed pieces; each invocation handles one column of four pixels. A dispatch has as
// many groups as piece_groups says.
#include "lib/holes.glsl"
layout(local_size_x = 64) in;

// The lowest pixel of this invocation's column; outside the picture if it has no work.
ivec2 first_of_column() {
    uint index = gl_GlobalInvocationID.x / uint(PIECE_WIDE), lane = gl_GlobalInvocationID.x % uint(PIECE_WIDE);
    return index < piece_count ? first_of_piece(int(pieces[index])) + ivec2(lane, 0) : shown_size;
}
