// Where a point of the rendered surface lies in the shown picture; depth is no part of its clip
// coordinates. `precise`, so that the corners of whole cells and of pieces are the same to the last
// bit, and no crack is between them.
#include "lib/warp_map.glsl"
uniform ivec2 shown_size;

// Homogeneous shown pixel. z, its w, is never 0: (0, 0, 0) would be inside the clip volume and have
// no place.
vec3 shown_point(vec2 pixel, float inverse_depth) {
    precise vec3 q = H * vec3(pixel, 1.0) + e * inverse_depth;
    return vec3(q.xy, q.z == 0.0 ? -1e-30 : q.z);
}

// z = 0: clipping by x and y leaves w > 0 alone, so what lies beside or behind the eye is cut off,
// not mirrored; depth is written by mesh_colour.glsl.
vec4 clip_position(vec2 pixel, float inverse_depth) {
    vec3 q = shown_point(pixel, inverse_depth);
    return vec4(2.0 * q.xy / vec2(shown_size) - q.z, 0.0, q.z);
}

// Whether a box may hold the centre of a shown pixel, as the rasteriser sees it: 1/512 off and in
// float32, so 1/64 for sure.
bool holds_a_centre(vec2 least, vec2 most) {
    vec2 first = ceil(max(least - 1.0 / 64.0, 0.0) - 0.5), last = floor(min(most + 1.0 / 64.0, vec2(shown_size)) - 0.5);
    return all(lessThanEqual(first, last));
}
