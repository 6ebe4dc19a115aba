// The surfaces of a rendered picture, and the mirror images that stand behind them.
//
// An eye is given as the rendered picture sees it: its place in homogeneous pixels, z its depth. A
// point at place p, inverse depth d, is (p, 1) / d. The ray from there to an eye crosses a plane
// where the plane's inverse depth, a linear function of the place, is that of the ray.
// Source: McMillan and Bishop 1995, Plenoptic Modeling, for the pixels; the crossing is elementary.
#define BLOCK 8 // pixels a side of what gets one depth of its mirror image
layout(r32f) readonly uniform image2D rendered_inverse_depth;
uniform ivec2 rendered_size;
#ifdef IMAGES
uniform sampler2D image_depth; // of each block: (inverse depth of the mirror image, 1), 0 where there is none
uniform vec2 image_depth_pixel; // 1 / (its size in rendered pixels)
#endif
const float CLOSEST = 0.94; // of the surface's inverse depth; a mirror image nearer to it does not move on it

bool is_depth(float inverse_depth) {
    return inverse_depth >= 0.0 && inverse_depth < 1e30; // false for NaN
}

bool of_one_surface(float a, float b) {
    return is_depth(a) && is_depth(b) && abs(a - b) <= SURFACE_TOLERANCE * (min(a, b) + SURFACE_FLOOR);
}

float depth_at(ivec2 texel) {
    return imageLoad(rendered_inverse_depth, clamp(texel, ivec2(0), rendered_size - 1)).r;
}

bool in_rendered(vec2 p) {
    return p.x >= 0.0 && p.y >= 0.0 && p.x < float(rendered_size.x) && p.y < float(rendered_size.y);
}

// Where the ray from a point to an eye crosses a plane. from: the point's place; own: its inverse
// depth; other: the plane's inverse depth there; at_eye: the plane's linear function at the eye.
vec3 crossing(vec3 from, float own, float other, float at_eye, vec3 eye) {
    return from * (1.0 - at_eye) + eye * (other - own);
}

#ifdef IMAGES
// The inverse depth of the mirror image at a place whose surface has inverse depth `own`; that of
// the surface where there is no image.
float image_at(vec2 place, float own) {
    vec2 found = textureLod(image_depth, place * image_depth_pixel, 0.0).rg;
    float image = found.r / max(found.g, 1e-6);
    return found.g >= 0.5 && is_depth(own) && image < CLOSEST * own ? image : own;
}

bool mirrors_at(vec2 place) {
    float own = depth_at(ivec2(place));
    return image_at(place, own) < own;
}

// The place of the mirror image that an eye sees at the surface at `from`; out of the picture if
// there is none. The image's depth there is found by repetition.
vec2 image_seen(vec3 from, float own, vec3 eye) {
    vec2 place = from.xy;
    float ahead = 1.0;
    for (int k = 0; k < 3; ++k) {
        float image = image_at(place, depth_at(ivec2(place)));
        vec3 q = crossing(from, own, image, image * eye.z, eye);
        ahead = q.z;
        place = q.z > 0.0 ? q.xy / q.z : place;
    }
    return ahead > 0.0 && in_rendered(place) && mirrors_at(place) ? place : vec2(-1.0);
}
#endif
