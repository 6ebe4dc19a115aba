// Scatters each rendered pixel; the last in an occlusion-compatible order wins, which needs the
// epipole and no depth.
// In: rendered pixel and inverse depth (for the landing alone). Out: shown colour; coverage 0 where
// nothing landed.
// Source: McMillan 1995 (A List-Priority Rendering Algorithm for Redisplaying Projected Surfaces,
// UNC TR95-005); Walia and Verma.
//
// The epipole is where the shown eye appears in the rendered picture. Two rendered pixels of one
// line through it may land in the same place, and then the one closer to it is nearer if the shown
// eye lies ahead (order: towards the epipole), the farther one if behind (away from it). So any
// order works that runs along each such line in that direction. The picture is cut at the epipole:
// RINGS: into four triangles by the diagonals through it, run in step, ring by ring of squares
// around it (with the halves of each triangle, McMillan's eight sheets). Else: into four quadrants,
// each run row by row (McMillan's four sheets).
#include "lib/scatter_in_order.glsl"
uniform ivec2 epipole; // the pixel that holds it, far outside for one at infinity
uniform int sense;     // 1 towards the epipole, -1 away from it
uniform ivec2 start;   // makes the smallest rank on each axis 0; start.x for rings

#ifdef RINGS
// From the top: 15 bits of ring, 2 of triangle, 15 of the place along its side. Each rendered pixel
// is in one triangle.
uint order_of(ivec2 rendered) {
    ivec2 d = rendered - epipole;
    bool beside = abs(d.x) >= abs(d.y);
    int outwards = beside ? d.x : d.y;
    uint triangle = (beside ? 0u : 2u) | (outwards < 0 ? 1u : 0u);
    return (uint(start.x - sense * abs(outwards)) << 17) | (triangle << 15) | uint(beside ? rendered.y : rendered.x);
}

ivec2 rendered_of(uint order) {
    int ring = sense * (start.x - int(order >> 17));
    int outwards = (order & 0x8000u) != 0u ? -ring : ring;
    int along = int(order & 0x7FFFu);
    return (order & 0x10000u) == 0u ? ivec2(epipole.x + outwards, along) : ivec2(along, epipole.y + outwards);
}
#else
// From the top: 15 bits of row, 15 of column, 2 of quadrant.
uint order_of(ivec2 rendered) {
    ivec2 d = rendered - epipole;
    uvec2 rank = uvec2(start - sense * abs(d));
    return (rank.y << 17) | (rank.x << 2) | (d.y < 0 ? 2u : 0u) | (d.x < 0 ? 1u : 0u);
}

ivec2 rendered_of(uint order) {
    ivec2 d = sense * (start - ivec2((order >> 2) & 0x7FFFu, order >> 17));
    return epipole + ivec2((order & 1u) != 0u ? -d.x : d.x, (order & 2u) != 0u ? -d.y : d.y);
}
#endif
