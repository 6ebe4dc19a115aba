// Add one depth layer to the shown picture: the nearest hit of each ray with any of the layers
// wins, the earlier layer of equals.
// In: shown pixel, the layer's inverse depth, a first guess per shown pixel. Out: the layer's
// colour where the ray meets it.
// Source: Shade et al. 1998, Layered Depth Images; the meeting as Bowles et al. 2012, Iterative
// Image Warping (lib/meeting.glsl).
#define BEST r32f
#include "lib/composite.glsl"
layout(r32f) readonly uniform image2D front_inverse_depth; // of the visible layer

// Pixels from the border of the rendered picture within which its surface may go on outside. Its
// depth is taken at one texel, so its place is exact to about half a pixel.
const float BORDER = 1.0;

// Whether the surface that occluded a place has moved off it, to `front` on the ray. If that lies
// outside the rendered picture, something else as near may be there, outside every picture, and
// still occlude the place.
bool is_uncovered(Ray ray, vec2 place) {
    float depth = imageLoad(front_inverse_depth, ivec2(place)).r;
    vec2 front = ray.start + depth * ray.along;
    return !is_depth(depth) || inside(front - BORDER, rendered_size - int(2.0 * BORDER));
}

bool may_belong(Ray ray, float nearest, vec4 before) {
    return is_nearer(nearest, before.r);
}

bool belongs(vec2 shown, Ray ray, Meeting found, vec4 before, out vec4 after) {
    after = vec4(found.depth);
    return (before.r < 0.0 || is_nearer(found.depth, before.r)) && (is_first || is_uncovered(ray, found.place));
}

void main() {
    ivec2 first = first_of_column();
    if (first.x >= shown_size.x) return;
    composite_column(first);
}
