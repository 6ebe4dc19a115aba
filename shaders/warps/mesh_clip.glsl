// Where a point of the late surface lies in the shown picture, as clip coordinates; depth is no part of them.
// `precise`, so that the corners of whole cells and of pieces are the same to the last bit, and no crack is between them.
#include "lib/warp_map.glsl"
uniform ivec2 shown_size;

// z = 0: clipping by x and y leaves w > 0 alone, so what lies beside or behind the eye is cut off, not mirrored; depth is written by
// mesh.frag. w is never 0, which would be inside the clip volume with x = y = 0 and have no place.
vec4 clip_position(vec2 pixel, float inverse_depth) {
    precise vec3 q = H * vec3(pixel, 1.0) + e * inverse_depth;
    float w = q.z == 0.0 ? -1e-30 : q.z;
    return vec4(2.0 * q.xy / vec2(shown_size) - w, 0.0, w);
}
