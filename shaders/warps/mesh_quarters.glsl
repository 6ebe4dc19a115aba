// The quarters of a cut cell: each corner that has depth keeps its quarter, at its own depth where
// the cell is cut.
// Needs mesh_surface.glsl.
const float OVERLAP = 1.0 / 64.0; // rendered pixels; the rasteriser moves corners by 1/512

struct Quarter {
    ivec2 cell, corner;
    // Inverse depth at its pixel, half way along x, along y, and at the middle of the cell
    float own, half_way, half_up, middle;
    vec2 towards;                         // direction from its pixel in which its colour may change along x, along y, 0 for none
};

Quarter quarter(uint piece, int c) {
    ivec2 cell = ivec2(piece & 0x3FFFu, piece >> 14u & 0x3FFFu), corner = ivec2(c & 1, c >> 1);
    uint edges = piece >> 28u;
    float own = known_inverse_depth(cell - 1 + corner);
    float beside = known_inverse_depth(cell - 1 + ivec2(1 - corner.x, corner.y));
    float above = known_inverse_depth(cell - 1 + ivec2(corner.x, 1 - corner.y));
    float across = known_inverse_depth(cell - corner);
    bool to_beside = (edges >> uint(corner.y) & 1u) != 0u, to_above = (edges >> uint(2 + corner.x) & 1u) != 0u;
    bool beside_up = (edges >> uint(3 - corner.x) & 1u) != 0u, above_on = (edges >> uint(1 - corner.y) & 1u) != 0u;

    // The middle of the cell, the same for all joined corners: the mean of opposite corners, or of
    // all four.
    bool has_across = (to_beside && beside_up) || (to_above && above_on);
    bool has_beside = to_beside || (to_above && above_on && beside_up);
    bool has_above = to_above || (to_beside && beside_up && above_on);
    float diagonal = 0.5 * (own + across), other = 0.5 * (beside + above);
    bool both = has_beside && has_above;
    float middle = has_across ? (both ? 0.5 * (diagonal + other) : diagonal)
                 : both ? other : has_beside ? 0.5 * (own + beside) : has_above ? 0.5 * (own + above) : own;
    float half_way = to_beside ? 0.5 * (own + beside) : own, half_up = to_above ? 0.5 * (own + above) : own;
    return Quarter(cell, corner, own, half_way, half_up, middle, vec2(to_beside, to_above) * vec2(1 - 2 * corner));
}

// Its corner `vertex` (0 or 1 on each axis): rendered pixel and inverse depth. At the middle of an
// edge lies a vertex that a whole neighbouring cell lacks, where the rasteriser may leave a gap. So
// a quarter extends a little over the border of its cell, where its own pixel continues in any
// case.
vec3 point_of(Quarter q, ivec2 vertex) {
    bvec2 inner = notEqual(vertex, q.corner);
    float r = all(inner) ? q.middle : inner.x ? q.half_way : inner.y ? q.half_up : q.own;
    float inwards_x = inner.y ? q.middle : q.half_way, inwards_y = inner.x ? q.middle : q.half_up;
    vec2 outwards = mix(vec2(2 * q.corner - 1), vec2(0.0), inner);
    r = max(r + 2.0 * OVERLAP * ((inner.x ? 0.0 : r - inwards_x) + (inner.y ? 0.0 : r - inwards_y)), 0.0);
    return vec3(clamp(vec2(q.cell) - 0.5 + 0.5 * vec2(q.corner + vertex) + OVERLAP * outwards, vec2(0.0), vec2(rendered_size)), r);
}
