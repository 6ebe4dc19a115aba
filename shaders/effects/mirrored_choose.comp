// Choose the depth of the mirror image for each block, by what the blocks around it say too.
// PASS 0 sums the costs along rows, over 3 and over 9 blocks; PASS 1 along columns, and chooses.
// In: per plane and block the sum of differences, and of how many samples. Out: the inverse depth of the image, and how much better it is than the surface: 0 to 1.
// Source: Scharstein and Szeliski 2002, A Taxonomy of Dense Two-Frame Stereo (windows, parabola).
#define GROUP_X 64
layout(local_size_x = GROUP_X, local_size_y = 1) in;
#include "effects/mirrored.glsl"
uniform ivec2 blocks;
const int WIDE = 4;         // blocks to each side; the narrow window has one
const float BETTER = 0.8;   // of the surface's cost, which the image's must stay below
const float LEAST = 0.002;  // by which it must be below that
const float NEAR = 0.97;    // the same as BETTER, in the narrow window
const float CLEAR = 0.05;   // a difference that leaves no doubt
#if PASS == 0
layout(rg16f, binding = 1) readonly uniform image2DArray given;
layout(rgba16f, binding = 2) writeonly uniform image2DArray written;

void visit(ivec2 block, int plane) {
    vec2 wide = vec2(0.0), narrow = vec2(0.0);
    for (int x = -WIDE; x <= WIDE; ++x) {
        if (block.x + x < 0 || block.x + x >= blocks.x) continue;
        vec2 cost = imageLoad(given, ivec3(block.x + x, block.y, plane)).rg;
        wide += cost;
        narrow += abs(x) <= 1 ? cost : vec2(0.0);
    }
    imageStore(written, ivec3(block, plane), vec4(narrow, wide));
}
#else
layout(rgba16f, binding = 1) readonly uniform image2DArray given;
layout(rg32f) writeonly uniform image2D written;

// x: of the narrow window; y: of both
vec2 cost_of(ivec2 block, int plane) {
    vec2 wide = vec2(0.0), narrow = vec2(0.0);
    for (int y = -WIDE; y <= WIDE; ++y) {
        if (block.y + y < 0 || block.y + y >= blocks.y) continue;
        vec4 row = imageLoad(given, ivec3(block.x, block.y + y, plane));
        wide += row.zw;
        narrow += abs(y) <= 1 ? row.xy : vec2(0.0);
    }
    float first = narrow.y > 0.0 ? narrow.x / narrow.y : 1e3;
    return vec2(first, first + (wide.y > 0.0 ? wide.x / wide.y : 1e3));
}

void visit(ivec2 block, int plane) {
    vec2 surface = cost_of(block, 0), best = vec2(1e9), last = surface, now = cost_of(block, 1);
    float share = 1.0;
    for (int j = 1; j <= PLANES; ++j) {
        vec2 next = j < PLANES ? cost_of(block, j + 1) : vec2(1e9);
        if (now.y < best.y) {
            best = now;
            float bend = last.y + next.y - 2.0 * now.y;
            float beside = j < PLANES && bend > 0.0 ? clamp(0.5 * (last.y - next.y) / bend, -0.5, 0.5) : 0.0;
            share = 1.0 - (float(j) + beside) / float(PLANES);
        }
        last = now;
        now = next;
    }
    float own = depth_at(min(block * BLOCK + BLOCK / 2, rendered_size - 1)), gain = surface.y - best.y;
    bool is_better = best.y < BETTER * surface.y && gain > LEAST && best.x <= NEAR * surface.x && best.y < 1e3;
    bool behind = is_depth(own) && own > 0.0 && share < CLOSEST;
    float trust = is_better && behind ? min(gain / CLEAR, 1.0) * gain / surface.y : 0.0;
    imageStore(written, block, vec4(is_depth(own) ? own * max(share, 0.0) : 0.0, trust, 0.0, 0.0));
}
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= blocks.x) return;
    if (at.y >= blocks.y * (PASS == 0 ? PLANES + 1 : 1)) return;
    visit(ivec2(at.x, at.y % blocks.y), at.y / blocks.y);
}
