// Find the triangles of cut cells that may be visible: most are smaller than a shown pixel and lie
// between centres. STAGE 0 counts them, STAGE 1 writes their list. In: the list of cut cells. Out:
// index of the cut cell << 3 corner << 1 half, chunk by chunk.
// Source: Wihlidal 2016, Optimizing the Graphics Pipeline with Compute (GDC): triangles that hold
// no sample are not worth drawing.
#include "warps/mesh_surface.glsl"
#include "warps/mesh_quarters.glsl"
#include "warps/mesh_clip.glsl"
#include "warps/mesh_draws.glsl"
#define GROUP_X 64
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 5) readonly buffer Pieces { uint pieces[]; };
layout(std430, binding = 8) buffer Chunks { uint in_chunk[]; };
layout(std430, binding = 9) buffer Masks { uvec2 mask_of[]; }; // a bit for each triangle, 8 in each of 8 cells
#if STAGE == 1
layout(std430, binding = 7) writeonly buffer Triangles { uint triangles[]; };
#endif

const float MARGIN = 1.0 / 64.0; // as in holds_a_centre

// A bit for each half of the quarter that may hold the centre of a shown pixel.
uint halves_seen(Quarter q) {
    vec2 place[4];
    bool before = true;
    for (int k = 0; k < 4; ++k) {
        vec3 point = point_of(q, ivec2(k & 1, k >> 1));
        vec3 homogeneous = shown_point(point.xy, point.z);
        place[k] = homogeneous.xy / homogeneous.z;
        before = before && homogeneous.z > 0.0;
    }
    vec2 least = min(min(place[0], place[1]), min(place[2], place[3])), most = max(max(place[0], place[1]), max(place[2], place[3]));
    // If the box contains a single centre, the half on its side of the diagonal is drawn: each half
    // is on its own side, or folded over, and then it faces away and is culled.
    vec2 centre = ceil(least - MARGIN - 0.5) + 0.5, diagonal = place[2] - place[1];
    bool one = all(lessThan(most + MARGIN, centre + 1.0));
    float side = diagonal.x * (centre.y - place[1].y) - diagonal.y * (centre.x - place[1].x);
    bool near = !one || abs(side) <= MARGIN * length(diagonal);
    uint halves = near ? 3u : side > 0.0 ? 1u : 2u;
    return q.own < 0.0 ? 0u : !before ? 3u : holds_a_centre(least, most) ? halves : 0u;
}

void main() {
    uint chunk = gl_GlobalInvocationID.x, count = chunks_in(cut_cells);
    if (chunk >= count) return;
#if STAGE == 0
    uvec2 mask = uvec2(0u);
    for (uint k = 0u; k < CHUNK; ++k) {
        uint piece = chunk * CHUNK + k, halves = 0u;
        for (int c = 0; c < 4; ++c) halves |= halves_seen(quarter(pieces[min(piece, cut_cells - 1u)], c)) << uint(2 * c);
        if (piece >= cut_cells) halves = 0u;
        if (k < 4u) mask.x |= halves << (k * 8u);
        else mask.y |= halves << (k * 8u - 32u);
    }
    mask_of[chunk] = mask;
    in_chunk[chunk] = uint(bitCount(mask.x) + bitCount(mask.y));
#else
    uint at = in_chunk[chunk];
    uvec2 mask = mask_of[chunk];
    for (uint k = 0u; k < 8u * CHUNK; ++k)
        if (((k < 32u ? mask.x : mask.y) >> (k & 31u) & 1u) != 0u) triangles[at++] = chunk * CHUNK * 8u + k;
#endif
}
