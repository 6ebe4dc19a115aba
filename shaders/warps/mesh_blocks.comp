// Find in each block of 4x4 cells the joined edges, the whole cells, and how flat they are
// together.
// In: rendered inverse depth. Out: a Block each; errors of flatness in 1/m, as the largest step
// between two levels, summed over levels.
// Source: Mark 1999, Post-Rendering 3D Image Warping, 3.3 (surfaces found in a depth picture);
// Schollmeyer et al. 2017 (the levels).
#include "warps/mesh_surface.glsl"
#include "warps/mesh_flatness.glsl"
#include "warps/mesh_clip.glsl"
#define GROUP_X 64
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) writeonly buffer Blocks { Block blocks[]; };
uniform vec2 steepest; // largest change of inverse depth between neighbours in x and in y, relative to the farther one

const int SIDE = 7;            // pixels around a block, one more on each side than its corners
// A step that differs by less than this share from the one before or after it belongs to a plane
const float STRAIGHT = 0.25;

bool joined(float before, float a, float b, float after, float limit) {
    if (a < 0.0 || b < 0.0) return false;
#if SLOPE
    float rise = b - a;
    bool shallow = abs(rise) <= limit * min(a, b);
    bool goes_on = before >= 0.0 && abs(rise - (a - before)) <= STRAIGHT * abs(rise);
    bool went_on = after >= 0.0 && abs((after - b) - rise) <= STRAIGHT * abs(rise);
    return shallow || goes_on || went_on;
#else
    return true;
#endif
}

#if ADAPTIVE
// The box around each cell in the shown picture; everything where a corner lies beside or behind
// the eye.
void bounds_of_cells(float r[SIDE * SIDE], ivec2 corner, out vec2 least[16], out vec2 most[16]) {
    vec2 place[25];
    uint before = 0u; // a bit each: Mesa's Zink makes no pipeline of an array of bool
    for (int k = 0; k < 25; ++k) {
        ivec2 at = ivec2(k % 5, k / 5);
        vec3 q = shown_point(clamp(vec2(corner + at) + 0.5, vec2(0.0), vec2(rendered_size)), r[(at.y + 1) * SIDE + at.x + 1]);
        place[k] = q.xy / q.z;
        before |= uint(q.z > 0.0) << uint(k);
    }
    for (int k = 0; k < 16; ++k) {
        int a = (k >> 2) * 5 + (k & 3);
        uint corners = before >> uint(a);
        bool all_before = (corners & (corners >> 1u) & (corners >> 5u) & (corners >> 6u) & 1u) != 0u;
        least[k] = all_before ? min(min(place[a], place[a + 1]), min(place[a + 5], place[a + 6])) : vec2(0.0);
        most[k] = all_before ? max(max(place[a], place[a + 1]), max(place[a + 5], place[a + 6])) : vec2(shown_size);
    }
}
#endif

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy), count = groups() * (GROUP / BLOCK);
    if (block.x >= count.x || block.y >= count.y) return;
    ivec2 first = first_cell(block);
    float r[SIDE * SIDE];
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) r[y * SIDE + x] = known_inverse_depth(first + ivec2(x, y) - 2);

    uint rows = 0u, columns = 0u; // joined edges
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 4; ++x) {
            int a = (y + 1) * SIDE + x + 1, c = (x + 1) * SIDE + y + 1;
            rows |= uint(joined(r[a - 1], r[a], r[a + 1], r[a + 2], steepest.x)) << uint(y * 4 + x);
            columns |= uint(joined(r[c - SIDE], r[c], r[c + SIDE], r[c + 2 * SIDE], steepest.y)) << uint(x * 5 + y);
        }

    uint whole = 0u, pieces = 0u;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            ivec2 cell = first + ivec2(x, y);
            bool exists = all(greaterThanEqual(cell, ivec2(0))) && all(lessThanEqual(cell, rendered_size));
            uint below = rows >> uint(y * 4 + x), left = columns >> uint(y * 5 + x);
            bool is_whole = (below & (below >> 4u) & left & (left >> 1u) & 1u) != 0u;
            int a = (y + 1) * SIDE + x + 1;
            bool some = max(max(r[a], r[a + 1]), max(r[a + SIDE], r[a + SIDE + 1])) >= 0.0;
            whole |= uint(exists && is_whole) << uint(y * 4 + x);
            pieces |= uint(exists && some && !is_whole) << uint(y * 4 + x);
        }

    uint shown = 0x80000000u, sizes[2] = uint[2](0u, 0u);
    float error = INFINITE;
#if ADAPTIVE
    ivec2 corner = first - 1;
    vec2 least[16], most[16];
    bounds_of_cells(r, corner, least, most);
    uint on_screen = 0u, hits = 0u;
    for (int k = 0; k < 16; ++k) {
        on_screen |= uint(all(greaterThan(most[k], vec2(-1.0))) && all(lessThan(least[k], vec2(shown_size + 1)))) << uint(k);
        hits |= uint(holds_a_centre(least[k], most[k])) << uint(k);
    }
    shown = on_screen != 0u ? 0x80000000u : 0u;

    bool inner = all(greaterThan(first, ivec2(0))) && all(lessThanEqual(first + BLOCK, rendered_size));
    float quarters = 0.0;
    for (int k = 0; k < 4; ++k) {
        int a = ((k >> 1) * 2 + 1) * SIDE + (k & 1) * 2 + 1;
        quarters = max(quarters, unevenness(r[a], r[a + 1], r[a + 2], r[a + SIDE], r[a + SIDE + 1], r[a + SIDE + 2],
                                            r[a + 2 * SIDE], r[a + 2 * SIDE + 1], r[a + 2 * SIDE + 2]));
    }
    int a = SIDE + 1, b = 3 * SIDE + 1, c = 5 * SIDE + 1;
    float bend = unevenness(r[a], r[a + 2], r[a + 4], r[b], r[b + 2], r[b + 4], r[c], r[c + 2], r[c + 4]);
    if (inner && whole == 0xFFFFu) error = quarters + bend;

    // Two cells merge if inverse depth continues straight across their common edge and each is
    // planar. Second differences below an eighth of the allowed error keep 4x4 cells within it: n *
    // n / 8 of those along x and y, and twice that of the mixed one, for n = 4.
    float allowed = coarsest >= 2 ? allowed_error(corner, BLOCK, r[a], r[a + 4], r[c], r[c + 4]) / 8.0 : -1.0;
    uint seen = whole & on_screen, planar = 0u, on_x = 0u, on_y = 0u;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            int k = (y + 1) * SIDE + x + 1;
            ivec2 cell = first + ivec2(x, y);
            bool within = all(greaterThan(cell, ivec2(0))) && all(lessThan(cell, rendered_size));
            float beside = max(abs(r[k] - 2.0 * r[k + 1] + r[k + 2]), abs(r[k + SIDE] - 2.0 * r[k + SIDE + 1] + r[k + SIDE + 2]));
            float above = max(abs(r[k] - 2.0 * r[k + SIDE] + r[k + 2 * SIDE]), abs(r[k + 1] - 2.0 * r[k + SIDE + 1] + r[k + 2 * SIDE + 1]));
            uint bit = 1u << uint(y * 4 + x);
            if (within && abs(r[k] - r[k + 1] - r[k + SIDE] + r[k + SIDE + 1]) <= allowed) planar |= bit;
            if (x < 3 && beside <= allowed) on_x |= bit;
            if (y < 3 && above <= allowed) on_y |= bit;
        }
    planar &= seen;
    on_x &= planar & planar >> 1u;
    on_y &= planar & planar >> 4u;

    // Start at each remaining cell: extend to the right as far as cells join, then up as far as
    // whole rows do.
    uint left = seen, begins = 0u;
    for (int k = 0; k < 16; ++k) {
        uint bit = 1u << uint(k), row = bit;
        if ((left & bit) == 0u) continue;
        int wide = 1, high = 1;
        for (int n = 1; n < 4; ++n)
            if (wide == n && (on_x & bit << uint(n - 1)) != 0u && (left & bit << uint(n)) != 0u) {
                row |= bit << uint(n);
                ++wide;
            }
        uint across = row & ~(bit << uint(wide - 1)); // cells that must join the next one in the row
        uint taken = row;
        for (int n = 1; n < 4; ++n) {
            uint above = row << uint(4 * n);
            bool goes_on = high == n && k + 4 * n < 16 && (on_y & row << uint(4 * n - 4)) == row << uint(4 * n - 4);
            if (goes_on && (left & above) == above && (on_x & across << uint(4 * n)) == across << uint(4 * n)) {
                taken |= above;
                ++high;
            }
        }
        left &= ~taken;
        if (wide * high > 1 || (hits & bit) != 0u) begins |= bit;
        uint size = uint(wide - 1 + 4 * (high - 1)) << uint((k & 7) * 4);
        if (k < 8) sizes[0] |= size;
        else sizes[1] |= size;
    }
    whole = begins;
#endif
    blocks[block_index(block)] = Block(whole | pieces << 16u, rows | shown, columns, floatBitsToUint(error), sizes[0], sizes[1]);
}
