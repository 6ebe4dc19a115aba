// The warp map of one eye: p_to ~ H p_from + e * inverse_depth, p in pixels (centres at i + 0.5,
// origin bottom left). The third component w of the result is the ratio of both depths along -z: w
// <= 0 lies beside or behind the `to` eye.
// Source: McMillan and Bishop 1995, Plenoptic Modeling; docs/conventions.md.
uniform mat3 H;
uniform vec3 e;
#ifdef SCANOUT
// Rows light up one after the other: H + t H_linear + t^2 H_square, t = 0 at the top of the
// display, 1 at its bottom.
uniform mat3 H_linear, H_square;
uniform vec3 e_linear, e_square;
#endif

bool inside(vec2 p, ivec2 size) {
    return p.x >= 0.0 && p.y >= 0.0 && p.x < float(size.x) && p.y < float(size.y);
}
