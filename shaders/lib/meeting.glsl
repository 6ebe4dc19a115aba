// Where the ray of a shown pixel meets the surface in a picture, and its colour there. H, e: shown
// -> rendered.
//
// Each texel is a plane over its own square, slanted towards those of its neighbours that belong to
// the same surface. In the rendered picture the ray is a line, on which the position of a point at
// rendered inverse depth r is linear in r: p = start + r * along. From a guess of r, one step to
// the plane of the texel there (Newton's) is exact as long as it stays on that plane.
// Source: Bowles et al. 2012, Iterative Image Warping, section 3; the slanted texels are this
// project's.
uniform sampler2D rendered_colour;
layout(r32f) readonly uniform image2D rendered_depth;
uniform ivec2 rendered_size;
uniform vec2 rendered_pixel;       // 1 / rendered_size
// Neighbours that differ by less than this times (their inverse depth + floor) are one surface
uniform float depth_tolerance;
uniform float depth_floor;     // 1/m
const float MOST_STEP = 0.5;   // pixels that a step may move from its start

struct Ray {
    bool ahead;
    vec2 start, along;
    float base_z, parallax_z;
};

struct Meeting {
    float depth;     // inverse depth in the shown view, -1 if the ray meets nothing
    vec2 place;      // rendered pixel
    vec2 colour_at;  // where to sample its colour
    bvec2 connected; // whether neighbouring texels along x and y are of the same surface
};

Ray ray_of(vec3 base, vec3 parallax) {
    vec2 start = base.xy / base.z;
    return Ray(base.z > 0.0, start, parallax.xy - start * parallax.z, base.z, parallax.z);
}

bool is_depth(float inverse_depth) {
    return inverse_depth >= 0.0 && inverse_depth < 1e30; // false for NaN too
}

bool of_one_surface(float a, float b) {
    return is_depth(b) && abs(a - b) <= depth_tolerance * (min(a, b) + depth_floor);
}

float held(ivec2 texel) {
    return imageLoad(rendered_depth, clamp(texel, ivec2(0), rendered_size - 1)).r;
}

// seed: an inverse depth in the shown view; negative: none.
Meeting meet(Ray ray, float seed) {
    float r = seed / (ray.base_z + seed * ray.parallax_z);
    vec2 p = ray.start + r * ray.along;
    // The texel that p lies in, and the two neighbours nearest to p.
    ivec2 corner = ivec2(floor(clamp(p, vec2(0.0), vec2(rendered_size)) + 0.5));
    bvec2 upper = greaterThanEqual(p, vec2(corner));
    ivec2 texel = corner - ivec2(not(upper)), other = corner - ivec2(upper);
    float own = held(texel);
    vec2 beside = vec2(held(ivec2(other.x, texel.y)), held(ivec2(texel.x, other.y)));
    vec2 side = mix(vec2(-0.5), vec2(0.5), upper);
    vec2 centre = vec2(texel) + 0.5;

    Meeting found;
    found.connected = bvec2(of_one_surface(own, beside.x), of_one_surface(own, beside.y));
    vec2 slope = mix(vec2(0.0), (vec2(own) - beside) * 2.0 * side, found.connected);
    // r + (own + slope . (p - centre) - r) / (1 + bend), without the difference of two r that may
    // be millions of times the result.
    float bend = max(-dot(slope, ray.along), -0.75);
    float step_to = max((own + dot(slope, p - centre) + r * bend) / (1.0 + bend), 0.0);
    float change = step_to - r;
    r = step_to;
    found.place = ray.start + r * ray.along;
    found.colour_at = mix(centre, found.place, found.connected);
    float nearer = 1.0 - r * ray.parallax_z;
    bool met = ray.ahead && seed >= 0.0 && is_depth(own) && nearer > 0.0 && abs(change) * length(ray.along) <= MOST_STEP;
    bool inside_rendered = all(greaterThanEqual(found.place, vec2(0.0))) && all(lessThan(found.place, vec2(rendered_size)));
    found.depth = met && inside_rendered ? r * ray.base_z / nearer : -1.0;
    return found;
}

// Whether `depth` is nearer than another by more than rounding: guesses often lead to the same
// point. Beyond 1000 km everything is equally far.
bool is_nearer(float depth, float other) {
    return depth * (1.0 - 1.0 / 65536.0) > other + 1.0 / 1048576.0;
}
