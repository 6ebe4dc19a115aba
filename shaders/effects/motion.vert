// Move the square that a moving pixel covers. It shares corners with neighbours of the same
// surface, so no crack opens.
// In: the list of moving pixels. Out: clip space of the rendered view; rendered pixel and inverse
// depth there, for perspective-correct interpolation.
// Source: Mark 1999, Post-Rendering 3D Image Warping, 3.3 (a surface from pixels, cut where depths
// do not join); McMillan 1995 (the map).
#include "effects/motion.glsl"
layout(std430, binding = 4) readonly buffer Pixels { uint pixels[]; };
uniform float nearest; // 1/m: nothing nearer is drawn
out vec3 surface_point;
flat out ivec3 owner; // the pixel, and what it moves with

void main() {
    uint listed = pixels[gl_VertexID >> 2];
    ivec2 pixel = ivec2(listed & 0xFFFFu, listed >> 16u), corner = ivec2(gl_VertexID & 1, gl_VertexID >> 1 & 1);
    // The four pixels around the corner; `own` is this one's index among them. `in` are those of
    // its surface, the same for each of them.
    ivec2 low = pixel + corner - 1;
    int own = 3 - (corner.x + 2 * corner.y);
    Seen around[4];
    for (int k = 0; k < 4; ++k) around[k] = seen(low + ivec2(k & 1, k >> 1));
    int x = own ^ 1, y = own ^ 2, across = own ^ 3;
    bool with_x = joined(around[own], around[x]), with_y = joined(around[own], around[y]);
    bool x_across = joined(around[x], around[across]), y_across = joined(around[y], around[across]);
    bool with_across = with_x && x_across || with_y && y_across;
    with_x = with_x || with_across && x_across;
    with_y = with_y || with_across && y_across;
    // In the same order for all four, so that they get the same bits.
    precise float r = 0.0;
    precise vec3 way = vec3(0.0);
    float count = 0.0;
    for (int k = 0; k < 4; ++k) {
        bool within = k == own || k == x && with_x || k == y && with_y || k == across && with_across;
        if (!within) continue;
        r += around[k].r;
        count += 1.0;
#if SOFT
        way += way_of(around[k].pixel);
#endif
    }
    r /= count;
    vec3 place = vec3(vec2(pixel + corner), 1.0);
    precise vec3 q = place;
#if SOFT
    q += way / count * r;
#endif
#if RIGID
    uint slot = min(around[own].key, uint(body_count)) - 1u;
    if (around[own].key <= uint(body_count)) {
        mat3 H = mat3(body_maps[4u * slot].xyz, body_maps[4u * slot + 1u].xyz, body_maps[4u * slot + 2u].xyz);
        q = H * place + body_maps[4u * slot + 3u].xyz * r;
    }
#endif
    surface_point = vec3(place.xy, r);
    owner = ivec3(pixel, int(around[own].key));
    // The depth-test value is linear in inverse depth: 1 at infinity and -1 at `nearest`.
    float w = q.z == 0.0 ? -1e-30 : q.z; // (0, 0, 0) would lie inside the clip volume at no position
    gl_Position = vec4(2.0 * q.xy / vec2(rendered_size) - w, w - 2.0 * r / nearest, w);
}
