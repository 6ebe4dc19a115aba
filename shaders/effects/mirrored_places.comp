// Where the rendered picture shows what each other eye sees mirrored in the surface at a pixel.
// In: the depths of the mirror images. Out: per other picture a place, below 0 if there is none.
// Source: lib/warp_map.glsl for the pixels; see effects/mirrored.glsl.
#include "lib/rows.glsl"
#define IMAGES
#include "effects/mirrored.glsl"
uniform int pictures;
uniform vec3 eyes[4];
layout(rg32f, binding = 2) writeonly uniform image2DArray written;

void main() {
    ivec2 p = first_pixel();
    if (p.x >= rendered_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= rendered_size.y) break;
        float own = depth_at(p);
        vec3 from = vec3(vec2(p) + 0.5, 1.0);
        bool mirrors = image_at(from.xy, own) < own;
        for (int k = 1; k < pictures; ++k) {
            vec2 place = vec2(-1.0);
            if (mirrors) place = image_seen(from, own, eyes[k]);
            imageStore(written, ivec3(p, k), vec4(place, 0.0, 0.0));
        }
    }
}
