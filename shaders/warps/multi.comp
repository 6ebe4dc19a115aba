// Add one rendered picture to the shown one: the nearest surface wins, of equally near ones the
// better sampled; surfaces of older pictures that the newest contradicts are left out.
// In: shown pixel, the picture's inverse depth, a first guess per shown pixel. Out: the picture's
// colour where it stays.
// Source: Mark et al. 1997, Post-Rendering 3D Warping (two reference frames, depth and
// connectedness); Mark 1999, chapter 3.
#define BEST rg32f // r: inverse depth, -1 for nothing; g: confidence
#include "lib/composite.glsl"
layout(r32f) readonly uniform image2D newest_inverse_depth;
uniform mat3 newest_H; // shown -> rendered, of the newest picture
uniform vec3 newest_e;
uniform ivec2 newest_size;
const float GAIN = 1.25; // factor by which an older picture must have sampled the place more densely; else the newest wins

// Whether the newest picture sees something farther through the place: then what an older one saw
// there has gone, or its depth was wrong.
bool is_contradicted(vec2 shown, float depth) {
    vec3 q = newest_H * vec3(shown, 1.0) + newest_e * depth;
    vec2 p = q.xy / q.z;
    float expected = depth / q.z, held = imageLoad(newest_inverse_depth, ivec2(p)).r;
    return q.z > 0.0 && inside(p, newest_size) && is_depth(held) && expected - held > depth_tolerance * (expected + depth_floor);
}

// Sampling density of the place in the picture, on each axis and relative to the shown one. Edges
// need no extra term: a hit spans connected texels only.
float confidence_of(Ray ray, float depth) {
    return 1.0 / (ray.base_z + depth * ray.parallax_z);
}

bool is_better(float depth, float confidence, vec4 before) {
    bool alike = abs(depth - before.r) <= depth_tolerance * (max(depth, before.r) + depth_floor);
    return alike ? confidence > GAIN * before.g : depth > before.r;
}

bool may_belong(Ray ray, float nearest, vec4 before) {
    return is_better(nearest, confidence_of(ray, nearest), before);
}

bool belongs(vec2 shown, Ray ray, Meeting found, vec4 before, out vec4 after) {
    after = vec4(found.depth, confidence_of(ray, found.depth), 0.0, 0.0);
    return is_first || ((before.r < 0.0 || is_better(after.r, after.g, before)) && !is_contradicted(shown, found.depth));
}

void main() {
    ivec2 first = first_of_column();
    if (first.x >= shown_size.x) return;
    composite_column(first);
}
