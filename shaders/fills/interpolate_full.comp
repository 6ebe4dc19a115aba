// One step of many: an empty pixel with at least `minimum_count` covered neighbours takes their
// median, in the active pieces.
// In: shown colour after the previous step. Out: shown colour; the pieces that the next step
// visits, and whether it runs at all.
// Source: the interpolation step of the 2014 thesis this project starts from, repeated.
//
// Two pictures alternate. The next step copies a newly filled pixel into the other picture, so a
// piece stays active until nothing in it changes; then both pictures are the same there.
#define ROWS 4 // of a piece; eight would spill registers
#include "lib/holes.glsl"
#include "lib/neighbour_median.glsl"
layout(local_size_x = 64) in;
layout(rgba16f) writeonly uniform image2D filled;
struct Step { uint groups, always_one, anything_changed, count; }; // the first three are the work groups of its indirect dispatch
layout(std430, binding = 1) buffer Steps { Step steps[]; };
layout(std430, binding = 2) readonly buffer From { uint at_work[]; };
layout(std430, binding = 3) buffer Next { uint at_work_next[]; };
// For each piece: the stamp of the step it was last listed for
layout(std430, binding = 4) buffer Listed { uint listed_in[]; };
uniform int step_number;
uniform uint stamp; // unique to each step of each run

void list_piece(uint piece) {
    if (atomicExchange(listed_in[piece], stamp) == stamp) return;
    uint slot = atomicAdd(steps[step_number + 1].count, 1u);
    at_work_next[slot] = piece;
    atomicMax(steps[step_number + 1].groups, slot * uint(PIECE_WIDE) / 64u + 1u);
}

// The lowest pixel of this invocation's column; outside the picture if it has no work.
ivec2 first_of_work() {
    uint index = gl_GlobalInvocationID.x / uint(PIECE_WIDE), lane = gl_GlobalInvocationID.x % uint(PIECE_WIDE);
    bool is_first = step_number == 0;
    if (index >= (is_first ? piece_count : steps[step_number].count)) return shown_size;
    uint piece = is_first ? pieces[index] : at_work[index];
    return first_of_piece(int(piece)) + ivec2(lane, 0);
}

void main() {
    ivec2 p = first_of_work();
    if (p.x >= shown_size.x) return;
    uint piece = uint(piece_of(p));
    bool changed = false, empty = false;
    Row below = row_at(p - ivec2(0, 1)), beside = row_at(p);
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= shown_size.y) break;
        Row above = row_at(p + ivec2(0, 1));
        bool hole = beside.middle.a == 0.0;
        vec4 colour = hole ? interpolated(below, beside, above) : beside.middle;
        imageStore(filled, p, colour);
        changed = changed || hole && colour.a > 0.0;
        empty = empty || colour.a == 0.0;
        below = beside;
        beside = above;
    }
    if (changed) steps[step_number + 1].anything_changed = 1u;
    if (changed || empty) list_piece(piece);
}
