// A moving pixel as the square it covers, moved. Its corners are shared with the neighbours of the same surface, so no crack opens.
// In: the list of moving pixels. Out: clip space of the late view; late pixel and inverse depth there, for perspective-correct interpolation.
// Source: Mark 1999, Post-Rendering 3D Image Warping, 3.3 (a surface from pixels, cut where depths do not join); McMillan 1995 (the map).
#include "effects/motion.glsl"
layout(std430, binding = 4) readonly buffer Pixels { uint pixels[]; };
uniform float nearest; // 1/m: nearer than this nothing is drawn
out vec3 surface_point;
flat out ivec3 owner; // the pixel, and what it moves with

#if SOFT
// Pixels times metres that a pixel goes.
vec3 way_of(ivec2 pixel) {
    vec3 way = texelFetch(late_velocity, clamp(pixel, ivec2(0), late_size - 1), 0).rgb * seconds;
    return pixel_from_eye * (way * min(1.0, reach_m / max(length(way), 1e-20)));
}
#endif

void main() {
    uint listed = pixels[gl_VertexID >> 2];
    ivec2 pixel = ivec2(listed & 0xFFFFu, listed >> 16u), corner = ivec2(gl_VertexID & 1, gl_VertexID >> 1 & 1);
    // The four pixels around the corner; `own` is this one among them. `in` are those of its surface, found alike from each of them.
    ivec2 low = pixel + corner - 1;
    int own = 3 - (corner.x + 2 * corner.y);
    uint keys[4];
    float depths[4];
    for (int k = 0; k < 4; ++k) {
        ivec2 here = low + ivec2(k & 1, k >> 1);
        keys[k] = moves_with(here);
        depths[k] = known_inverse_depth(here);
    }
    int x = own ^ 1, y = own ^ 2, across = own ^ 3;
    bool with_x = joined(keys[own], keys[x], depths[own], depths[x], vec2(1.0, 0.0));
    bool with_y = joined(keys[own], keys[y], depths[own], depths[y], vec2(0.0, 1.0));
    bool x_across = joined(keys[x], keys[across], depths[x], depths[across], vec2(0.0, 1.0));
    bool y_across = joined(keys[y], keys[across], depths[y], depths[across], vec2(1.0, 0.0));
    bool with_across = with_x && x_across || with_y && y_across;
    with_x = with_x || with_across && x_across;
    with_y = with_y || with_across && y_across;
    // In one order for all four, so that they get the same bits.
    precise float r = 0.0;
    precise vec3 way = vec3(0.0);
    float count = 0.0;
    for (int k = 0; k < 4; ++k) {
        bool within = k == own || k == x && with_x || k == y && with_y || k == across && with_across;
        if (!within) continue;
        r += depths[k];
        count += 1.0;
#if SOFT
        way += way_of(low + ivec2(k & 1, k >> 1));
#endif
    }
    r /= count;
    vec3 place = vec3(vec2(pixel + corner), 1.0);
    precise vec3 q = place;
#if SOFT
    q += way / count * r;
#endif
#if RIGID
    uint slot = min(keys[own], uint(body_count)) - 1u;
    if (keys[own] <= uint(body_count)) {
        mat3 H = mat3(body_maps[4u * slot].xyz, body_maps[4u * slot + 1u].xyz, body_maps[4u * slot + 2u].xyz);
        q = H * place + body_maps[4u * slot + 3u].xyz * r;
    }
#endif
    surface_point = vec3(place.xy, r);
    owner = ivec3(pixel, int(keys[own]));
    // The depth that is tested is linear in the inverse depth, 1 for infinitely far and -1 for `nearest`.
    float w = q.z == 0.0 ? -1e-30 : q.z; // (0, 0, 0) would be inside the clip volume and have no place
    gl_Position = vec4(2.0 * q.xy / vec2(late_size) - w, w - 2.0 * r / nearest, w);
}
