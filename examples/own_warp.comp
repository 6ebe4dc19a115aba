// Gathers each shown pixel as if the rendered picture were painted on a wall in front of the rendered eye.
// In: shown pixel. Out: rendered pixel where its ray meets the plane z = -distance_m of the rendered eye.
// Source: docs/conventions.md, the warp map.
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 shown_size;
uniform float distance_m;

void main() {
    ivec2 first = first_pixel();
    prepare_sampling();
    for (int row = 0; row < ROWS; ++row) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.x >= shown_size.x || pixel.y >= shown_size.y) return;
        vec3 base = H * vec3(vec2(pixel) + 0.5, 1.0);
        vec3 q = base + e * base.z / (distance_m - e.z); // the rendered pixel, homogeneous, of the point on the wall
        vec2 p = q.xy / q.z;
        imageStore(written, pixel, q.z > 0.0 && in_rendered(p) ? covered_average(p) : vec4(0.0));
    }
}
