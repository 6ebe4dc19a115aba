// A million warp maps, one per invocation, evaluated as the warps do: base = H p, q = base + e r, q.xy / q.z.
// In: map, pixel and inverse depth, 16 floats each. Out: pixel, w, 1 where the warps would call the place defined (w > 0, inside, depth >= 0).
// Source: shaders/lib/warp_map.glsl, whose inside() it shares; tests/hard_cases/test_sweep.py holds it against float64.
#define GROUP_X 256
layout(local_size_x = GROUP_X) in;
#include "lib/warp_map.glsl"
struct Case { vec4 h0, h1, h2, depth_and_size; }; // rows of H, each with its e; pixel xy, inverse depth, side of the picture
layout(std430, binding = 0) readonly buffer Cases { Case cases[]; };
layout(std430, binding = 1) writeonly buffer Results { vec4 results[]; };
uniform int count;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= count) return;
    Case c = cases[i];
    vec2 p = c.depth_and_size.xy;
    float r = c.depth_and_size.z;
    // As to_shown.glsl: the product at the first row, and steps of one row from there.
    float row = mod(floor(p.y), 8.0);
    vec3 start = vec3(p.x, p.y - row, 1.0);
    vec3 base = vec3(dot(c.h0.xyz, start), dot(c.h1.xyz, start), dot(c.h2.xyz, start)) + vec3(c.h0.y, c.h1.y, c.h2.y) * row;
    vec3 q = base + vec3(c.h0.w, c.h1.w, c.h2.w) * r;
    vec2 place = q.xy / q.z;
    bool defined_there = r >= 0.0 && q.z > 0.0 && inside(place, ivec2(c.depth_and_size.w));
    results[i] = defined_there ? vec4(place, q.z, 1.0) : vec4(0.0);
}
