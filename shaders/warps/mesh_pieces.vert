// A cell that is no surface as a whole: a quarter for each corner that has depth, at that corner's own depth where the cell is cut.
// In: the list of cells in pieces, with their joined edges. Out: as mesh_cells.vert; which pixel a quarter belongs to.
// Source: Mark 1999, Post-Rendering 3D Image Warping, 3.3: a cut surface ends half a pixel from its last centre.
#include "warps/mesh_surface.glsl"
#include "warps/mesh_clip.glsl"
layout(std430, binding = 5) readonly buffer Pieces { uint pieces[]; };
out vec2 drawn;
out float drawn_inverse_depth;
flat out vec4 owner; // centre of the pixel it belongs to; which way from there its colour may change along x, along y, 0 for not

const float OVERLAP = 1.0 / 64.0; // rendered pixels; the rasteriser moves corners by 1/512

void main() {
    uint piece = pieces[gl_VertexID >> 4];
    ivec2 cell = ivec2(piece & 0x3FFFu, piece >> 14u & 0x3FFFu);
    int c = gl_VertexID >> 2 & 3;
    ivec2 corner = ivec2(c & 1, c >> 1), vertex = ivec2(gl_VertexID & 1, gl_VertexID >> 1 & 1);
    uint edges = piece >> 28u;
    float own = known_inverse_depth(cell - 1 + corner);
    float beside = known_inverse_depth(cell - 1 + ivec2(1 - corner.x, corner.y));
    float above = known_inverse_depth(cell - 1 + ivec2(corner.x, 1 - corner.y));
    float across = known_inverse_depth(cell - corner);
    bool to_beside = (edges >> uint(corner.y) & 1u) != 0u, to_above = (edges >> uint(2 + corner.x) & 1u) != 0u;
    bool beside_up = (edges >> uint(3 - corner.x) & 1u) != 0u, above_on = (edges >> uint(1 - corner.y) & 1u) != 0u;

    // The middle of the cell, the same for all that are joined: opposite corners' mean, or all four's.
    bool has_across = (to_beside && beside_up) || (to_above && above_on);
    bool has_beside = to_beside || (to_above && above_on && beside_up);
    bool has_above = to_above || (to_beside && beside_up && above_on);
    float diagonal = 0.5 * (own + across), other = 0.5 * (beside + above);
    bool both = has_beside && has_above;
    float middle = has_across ? (both ? 0.5 * (diagonal + other) : diagonal)
                 : both ? other : has_beside ? 0.5 * (own + beside) : has_above ? 0.5 * (own + above) : own;

    float half_way = to_beside ? 0.5 * (own + beside) : own, half_up = to_above ? 0.5 * (own + above) : own;
    // Corners of the quarter: at its pixel, half way beside it, half way above or below it, at the middle of the cell.
    bvec2 inner = notEqual(vertex, corner);
    float r = all(inner) ? middle : inner.x ? half_way : inner.y ? half_up : own;
    float inwards_x = inner.y ? middle : half_way, inwards_y = inner.x ? middle : half_up;

    // Half way lies a vertex that a whole cell beside has not, and the rasteriser may leave a gap there. So a quarter reaches a
    // little over the border of its cell, where its own pixel goes on in any case.
    vec2 outwards = mix(vec2(2 * corner - 1), vec2(0.0), inner);
    r = max(r + 2.0 * OVERLAP * ((inner.x ? 0.0 : r - inwards_x) + (inner.y ? 0.0 : r - inwards_y)), 0.0);
    drawn = clamp(vec2(cell) - 0.5 + 0.5 * vec2(corner + vertex) + OVERLAP * outwards, vec2(0.0), vec2(late_size));
    drawn_inverse_depth = r;
    vec2 free = vec2(to_beside, to_above);
    owner = vec4(vec2(clamp(cell - 1 + corner, ivec2(0), late_size - 1)) + 0.5, free * vec2(1 - 2 * corner));
    gl_Position = own >= 0.0 ? clip_position(drawn, r) : vec4(0.0, 0.0, 0.0, -1.0);
}
