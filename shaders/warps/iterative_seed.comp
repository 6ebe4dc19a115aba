// Splat rendered depth at a quarter of the resolution, the nearest texel of each block, so that a
// gather starts on the front surface.
// In: rendered inverse depth. Out: per cell of shown pixels the inverse depth where its central ray
// meets the plane of the texel in front.
// Source: Lee et al. 2018, Iterative Depth Warping (a first guess by warping depth forward);
// McMillan and Bishop 1995 for the map.
//
// PASS 0 finds the nearest texel of each block, PASS 1 splats the blocks, PASS 2 intersects rays and
// planes, and empties the cells for the next time.
#define ROWS 1
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
#include "lib/rendered_surface.glsl"
#include "lib/seeds.glsl"
struct Block {
    float nearest, farthest; // inverse depth, nearest < 0 if the block has none
    ivec2 texel;             // the nearest
};
layout(std430, binding = 1) buffer Blocks { Block block_of[]; };
layout(std430, binding = 2) buffer Keys { uint key_of[]; }; // of each cell, see lib/seeds.glsl
uniform ivec2 grid, blocks, index_bits;

const uint NEAREST_BITS = 0x44FFFFFFu;  // the largest float32 below 2^11 1/m
const uint FARTHEST_BITS = 0x35800000u; // 2^-20 1/m
// A block covers its footprint at its nearest depth and down to this share of it
const float SAME_SURFACE = 0.9;
const int MOST_CELLS = 8;               // covered by a block on each axis

#if PASS == 0
void visit(ivec2 block) {
    Block found = Block(-1.0, 1e30, ivec2(0));
    for (int y = 0; y < BLOCK; ++y)
        for (int x = 0; x < BLOCK; ++x) {
            ivec2 texel = block * BLOCK + ivec2(x, y);
            float here = imageLoad(rendered_inverse_depth, texel).r; // 0 beyond the border, which lands nowhere
            bool nearer = here > found.nearest && here < 1e30;
            found.nearest = nearer ? here : found.nearest;
            found.texel = nearer ? texel : found.texel;
            found.farthest = here >= 0.0 ? min(found.farthest, here) : found.farthest;
        }
    block_of[block.y * blocks.x + block.x] = found;
}
#elif PASS == 1
void visit(ivec2 block) {
    Block found = block_of[block.y * blocks.x + block.x];
    float farthest = max(found.farthest, SAME_SURFACE * found.nearest);
    vec3 first = H * vec3(vec2(block * BLOCK), 1.0);
    vec2 low = vec2(1e9), high = vec2(-1e9);
    float least_w = 1e30;
    for (int k = 0; k < 8; ++k) {
        vec3 q = first + H[0] * float(BLOCK * (k & 1)) + H[1] * float(BLOCK * (k >> 1 & 1)) + e * (k < 4 ? found.nearest : farthest);
        vec2 p = clamp(q.xy / (q.z * float(BLOCK)), vec2(-1.0), vec2(cells));
        low = min(low, p);
        high = max(high, p);
        least_w = min(least_w, q.z);
    }
    uint bits = min(floatBitsToUint(found.nearest), NEAREST_BITS);
    if (!(found.nearest > 0.0 && bits >= FARTHEST_BITS && least_w > 0.0)) return;
    int free = index_bits.x + index_bits.y;
    uint key = ((bits - FARTHEST_BITS) << 4) >> free << free | uint(found.texel.y << index_bits.x | found.texel.x);
    ivec2 from = max(ivec2(floor(low)), ivec2(0));
    ivec2 to = min(min(ivec2(floor(high)), cells - 1), from + MOST_CELLS - 1);
    for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x) atomicMax(key_of[y * cells.x + x], key);
}
#else
void visit(ivec2 cell) {
    int slot = cell.y * cells.x + cell.x;
    uint key = key_of[slot];
    key_of[slot] = 0u;
    vec3 base = H * vec3((vec2(cell) + 0.5) * float(BLOCK), 1.0);
    vec2 start = base.xy / base.z;
    ivec2 texel = ivec2(key & ((1u << index_bits.x) - 1u), (key >> index_bits.x) & ((1u << index_bits.y) - 1u));
    // Slanted towards its neighbours in the block, which are more likely to belong to its surface.
    vec2 place = vec2(texel) + mix(vec2(0.25), vec2(0.75), lessThan(texel & (BLOCK - 1), ivec2(BLOCK / 2)));
    float r = meets(surface_at(place, 0.0), place, start, e.xy - start * e.z);
    // A ray behind the rendered eye has no line in its picture, though the division gives one.
    seed_of[slot] = key != 0u && base.z > 0.0 && r > 0.0 && r < 1e30 ? floatBitsToUint(r) : 0u;
}
#endif

void main() {
    ivec2 at = first_pixel();
    if (at.x >= grid.x || at.y >= grid.y) return;
    visit(at);
}
