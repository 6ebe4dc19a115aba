// Gathers each shown pixel as if the rendered picture were painted on a wall before the rendered eye.
// In: shown pixel. Out: rendered pixel where its ray meets the plane z = -distance_m of the rendered eye.
// Source: docs/conventions.md, the warp map.
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
layout(rgba16f) writeonly uniform image2D written;
uniform sampler2D rendered_colour; // premultiplied by coverage, which is its alpha
uniform ivec2 rendered_size, shown_size;
uniform float distance_m;

void main() {
    ivec2 first = first_pixel();
    for (int row = 0; row < ROWS; ++row) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.x >= shown_size.x || pixel.y >= shown_size.y) return;
        vec3 base = H * vec3(vec2(pixel) + 0.5, 1.0);
        vec3 q = base + e * base.z / (distance_m - e.z); // of the point on the wall, homogeneous
        vec2 p = q.xy / q.z;
        vec4 sum = texture(rendered_colour, p / vec2(rendered_size));
        bool covered = q.z > 0.0 && inside(p, rendered_size) && sum.a >= 0.5;
        imageStore(written, pixel, covered ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0));
    }
}
