// Shared by the passes of fill `relight`: the light of the shown picture in blocks of BLOCK x BLOCK
// pixels. Of each block only the farthest surface counts, so that none is lit by surfaces in front
// of it. A surface is a plane of inverse depth.
const int BLOCK = 8;
const float FLOOR = 0.02; // 1/m: nothing is farther than 50 m, so that the sky has a position

// Three texels a block, side by side. rgb of the first: shown colour, the mean over all pixels of
// the block, 0 for those that do not count; of the second: the model's colour, likewise (its
// albedo, or albedo times baked light); of the third: the surface's position, in metres along the
// eye's axes. The three alphas together: its normal, of length 1. An image, because llvmpipe loads
// its texels whole and a buffer's numbers one by one: half the time.
const int PARTS = 3;
uniform vec2 first_tangent, pixel_tangent; // of the picture's corner, of one pixel

vec3 point_at(vec2 p, float depth) {
    return vec3(first_tangent + p * pixel_tangent, -1.0) / (depth + FLOOR);
}

// The normal of a plane of inverse depth, away from the eye, in eye axes: of n.p = d, inverse depth
// is (n.x x + n.y y - n.z) / d.
vec3 normal_at(vec2 p, float depth, vec2 slope) {
    vec2 across = slope / pixel_tangent;
    vec3 away = vec3(across, dot(across, first_tangent + p * pixel_tangent) - depth);
    float size = length(away);
    return size > 1e-9 ? away / size : vec3(0.0, 0.0, -1.0);
}
