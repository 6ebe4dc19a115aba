// Normals of surfaces, from a picture of their inverse depth: a surface is a plane of inverse depth.
// The including shader declares shown_size.
// Source: inverse depth is linear in the picture across a plane (docs/conventions.md).
layout(r32f) readonly uniform image2D model_inverse_depth;
uniform vec2 tangent_start, tangent_step; // of the picture's corner, of one pixel
const float FLOOR = 0.02; // 1/m: nothing is farther than 50 m, so that the sky has a position

// The normal of a plane of inverse depth, away from the eye, in eye axes: of n.p = d, inverse depth
// is (n.x x + n.y y - n.z) / d.
vec3 normal_at(vec2 p, float depth, vec2 slope) {
    vec2 across = slope / tangent_step;
    vec3 away = vec3(across, dot(across, tangent_start + p * tangent_step) - depth);
    float size = length(away);
    return size > 1e-9 ? away / size : vec3(0.0, 0.0, -1.0);
}

// Of the slopes towards both neighbours the smaller one, which does not cross an edge. At the
// border there is one neighbour.
vec2 slope_at(ivec2 p, float depth) {
    ivec2 low = max(p - 1, ivec2(0)), high = min(p + 1, shown_size - 1);
    vec2 back = depth - vec2(imageLoad(model_inverse_depth, ivec2(low.x, p.y)).r, imageLoad(model_inverse_depth, ivec2(p.x, low.y)).r);
    vec2 ahead = vec2(imageLoad(model_inverse_depth, ivec2(high.x, p.y)).r, imageLoad(model_inverse_depth, ivec2(p.x, high.y)).r) - depth;
    bvec2 gentler = lessThanEqual(abs(ahead), abs(back)), first = equal(p, ivec2(0)), last = equal(p, high);
    return mix(back, ahead, bvec2(first.x || (gentler.x && !last.x), first.y || (gentler.y && !last.y)));
}
