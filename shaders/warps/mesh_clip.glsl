// The position of a rendered surface point in the shown picture; depth is not part of its clip
// coordinates. `precise`, so that the corners of whole cells and of pieces are identical to the
// last bit, without cracks between them.
#include "lib/warp_map.glsl"
uniform ivec2 shown_size;

// Homogeneous shown pixel. z, its w, is never 0: (0, 0, 0) would lie inside the clip volume at no
// position.
vec3 shown_point(vec2 pixel, float inverse_depth) {
    precise vec3 q = H * vec3(pixel, 1.0) + e * inverse_depth;
    return vec3(q.xy, q.z == 0.0 ? -1e-30 : q.z);
}

// z = 0: clipping by x and y leaves only w > 0, so points beside or behind the eye are cut off, not
// mirrored; depth is written by mesh_colour.glsl.
vec4 clip_position(vec2 pixel, float inverse_depth) {
    vec3 q = shown_point(pixel, inverse_depth);
    return vec4(2.0 * q.xy / vec2(shown_size) - q.z, 0.0, q.z);
}

// Whether a box may contain the centre of a shown pixel, as the rasteriser sees it: off by 1/512
// and in float32, so a margin of 1/64 is safe.
bool holds_a_centre(vec2 least, vec2 most) {
    vec2 first = ceil(max(least - 1.0 / 64.0, 0.0) - 0.5), last = floor(min(most + 1.0 / 64.0, vec2(shown_size)) - 0.5);
    return all(lessThanEqual(first, last));
}
