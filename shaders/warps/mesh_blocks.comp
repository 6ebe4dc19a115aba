// Finds in each block of 4x4 cells which edges are joined, which cells are whole, and how flat they are together.
// In: rendered inverse depth. Out: a Block each; errors of flatness in 1/m, as the largest step between two levels, summed over levels.
// Source: Mark 1999, Post-Rendering 3D Image Warping, 3.3 (surfaces found in a depth picture); Schollmeyer et al. 2017 (the levels).
#include "warps/mesh_surface.glsl"
#include "warps/mesh_flatness.glsl"
#define GROUP_X 64
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) writeonly buffer Blocks { Block blocks[]; };
uniform vec2 steepest; // what inverse depth may change by between neighbours in x and in y, relative to the farther one

const int SIDE = 7;            // pixels around a block, one more on each side than its corners
const float STRAIGHT = 0.25;   // a step that differs by less than this part from the one before or after it is a plane's

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

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy), count = groups() * (GROUP / BLOCK);
    if (block.x >= count.x || block.y >= count.y) return;
    ivec2 first = first_cell(block);
    float r[SIDE * SIDE];
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) r[y * SIDE + x] = known_inverse_depth(first + ivec2(x, y) - 2);

    uint rows = 0u, columns = 0u;
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
            bool exists = all(greaterThanEqual(cell, ivec2(0))) && all(lessThanEqual(cell, late_size));
            uint below = rows >> uint(y * 4 + x), left = columns >> uint(y * 5 + x);
            bool is_whole = (below & (below >> 4u) & left & (left >> 1u) & 1u) != 0u;
            int a = (y + 1) * SIDE + x + 1;
            bool some = max(max(r[a], r[a + 1]), max(r[a + SIDE], r[a + SIDE + 1])) >= 0.0;
            whole |= uint(exists && is_whole) << uint(y * 4 + x);
            pieces |= uint(exists && some && !is_whole) << uint(y * 4 + x);
        }

    uint flats = 0u;
    float error = INFINITE;
#if ADAPTIVE
    bool inner = all(greaterThan(first, ivec2(0))) && all(lessThanEqual(first + BLOCK, late_size));
    float quarters = 0.0;
    for (int k = 0; k < 4; ++k) {
        int a = ((k >> 1) * 2 + 1) * SIDE + (k & 1) * 2 + 1;
        float bend = unevenness(r[a], r[a + 1], r[a + 2], r[a + SIDE], r[a + SIDE + 1], r[a + SIDE + 2],
                                r[a + 2 * SIDE], r[a + 2 * SIDE + 1], r[a + 2 * SIDE + 2]);
        uint cells = 0x33u << uint((k >> 1) * 8 + (k & 1) * 2);
        ivec2 corner = first + 2 * ivec2(k & 1, k >> 1);
        bool within = all(greaterThan(corner, ivec2(0))) && all(lessThanEqual(corner + 2, late_size));
        float allowed = allowed_error(corner - 1, 2, r[a], r[a + 2], r[a + 2 * SIDE], r[a + 2 * SIDE + 2]);
        flats |= uint(within && coarsest >= 2 && (whole & cells) == cells && bend <= allowed) << uint(k);
        quarters = max(quarters, bend);
    }
    int a = SIDE + 1, b = 3 * SIDE + 1, c = 5 * SIDE + 1;
    float bend = unevenness(r[a], r[a + 2], r[a + 4], r[b], r[b + 2], r[b + 4], r[c], r[c + 2], r[c + 4]);
    if (inner && whole == 0xFFFFu) error = quarters + bend;
#endif
    blocks[block_index(block)] = Block(whole | pieces << 16u, rows | flats << 20u, columns, floatBitsToUint(error));
}
