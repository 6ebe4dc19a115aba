// The surface in the rendered picture: every texel is a plane over its own square, slanted towards
// those of its neighbours that are connected with it. Where neighbours are not connected the
// surface ends half way between them, so that no rubber sheet joins them.
layout(r32f) readonly uniform image2D rendered_inverse_depth;
uniform vec2 last_centre; // of the texels of the rendered picture
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

struct Surface {
    bool known;
    float depth;     // inverse depth at the place
    vec2 slope;      // 1/m per pixel, 0 towards a neighbour that is not connected
    vec2 centre;     // of the texel that the place lies in
    bvec2 connected; // with the neighbour nearest to the place, along x and along y
};

bool is_depth(float inverse_depth) {
    return inverse_depth >= 0.0 && inverse_depth < 1e30; // false for NaN
}

bool are_connected(float a, float b, float joined) {
    return b >= 0.0 && abs(a - b) <= max(depth_tolerance * (min(a, b) + depth_floor), joined);
}

ivec2 texel_at(vec2 p) {
    return ivec2(clamp(p, vec2(0.0), last_centre));
}

// The surface at p; outside the picture the extended surface of the nearest texel. joined: 1/m by
// which neighbours may differ in any case, and be connected. It takes three loads, which are
// cheaper on llvmpipe than a gather of four and its selections. The texel across the corner is not
// loaded (a fourth load costs `iterative` a third of its time): where it alone is of another
// surface, at the inner corners of silhouettes, it contributes up to a quarter of the colour.
// Beyond the border the outermost texels go on, as their colours do.
Surface surface_at(vec2 p, float joined) {
    ivec2 texel = texel_at(p);
    Surface found;
    found.centre = vec2(texel) + 0.5;
    vec2 off = p - found.centre;
    ivec2 side = ivec2(off.x < 0.0 ? -1 : 1, off.y < 0.0 ? -1 : 1);
    float own = imageLoad(rendered_inverse_depth, texel).r;
    ivec2 other = texel_at(found.centre + vec2(side));
    float beside = imageLoad(rendered_inverse_depth, ivec2(other.x, texel.y)).r;
    float above = imageLoad(rendered_inverse_depth, ivec2(texel.x, other.y)).r;
    found.known = is_depth(own);
    found.connected = bvec2(are_connected(own, beside, joined), are_connected(own, above, joined));
    found.slope = vec2(found.connected.x ? (beside - own) * float(side.x) : 0.0, found.connected.y ? (above - own) * float(side.y) : 0.0);
    found.depth = own + dot(found.slope, off);
    return found;
}

// Where to sample the colour of p: between texels only where they belong to one surface.
vec2 colour_place(Surface surface, vec2 p) {
    return mix(surface.centre, p, surface.connected);
}

// The inverse depth at which a ray with position start + r * along meets the plane of a surface
// found at `place`. Beyond a slope of 0.75 the ray is nearly parallel to the plane; such a step is
// limited to four times the plain one.
float meets(Surface surface, vec2 place, vec2 start, vec2 along) {
    float own = surface.depth + dot(surface.slope, start - place);
    return own / max(1.0 - dot(surface.slope, along), 0.25);
}
