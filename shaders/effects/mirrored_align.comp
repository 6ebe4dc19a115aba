// Bring another picture onto the surfaces of the rendered one.
// In: rendered inverse depth; the other picture with its own. Out: one layer: its colour at each
// rendered surface, alpha 1 where it sees that surface, else 0. OWN copies the rendered picture.
// Source: Sinha et al. 2012, Image-Based Rendering for Scenes with Reflections, section 4.
#include "lib/rows.glsl"
#include "effects/mirrored.glsl"
layout(rgba16f, binding = 2) writeonly uniform image2DArray written;
uniform int layer;
#ifdef OWN
layout(rgba16f) readonly uniform image2D given; // the rendered colour
#else
#include "lib/warp_map.glsl"
uniform sampler2D other_colour;
layout(r32f) readonly uniform image2D other_inverse_depth;
uniform ivec2 other_size;
uniform vec2 other_pixel; // 1 / other_size
#endif

vec4 colour_at(ivec2 pixel) {
    float own = depth_at(pixel);
#ifdef OWN
    vec4 found = imageLoad(given, pixel);
    return is_depth(own) && found.a >= 0.5 ? vec4(found.rgb / found.a, 1.0) : vec4(0.0);
#else
    vec3 q = H * vec3(vec2(pixel) + 0.5, 1.0) + e * own;
    vec2 place = q.xy / q.z;
    if (!is_depth(own) || q.z <= 0.0 || !inside(place, other_size)) return vec4(0.0);
    vec4 found = textureLod(other_colour, place * other_pixel, 0.0);
    bool seen = of_one_surface(own / q.z, imageLoad(other_inverse_depth, ivec2(place)).r);
    return seen && found.a >= 0.5 ? vec4(found.rgb / found.a, 1.0) : vec4(0.0);
#endif
}

void main() {
    ivec2 p = first_pixel();
    if (p.x >= rendered_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= rendered_size.y) break;
        imageStore(written, ivec3(p, layer), colour_at(p));
    }
}
