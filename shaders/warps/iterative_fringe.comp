// Moves the outermost pixel of what lies behind a silhouette with the surface in front:
// antialiasing has mixed that surface's colour into it.
// In: rendered inverse depth. Out: the same, beside a step that of the nearest of four neighbours.
// Source: this project's; openwarp (Huzaifa et al. 2021, ILLIXR) moves its vertices likewise.
#define ROWS 4
#include "lib/rows.glsl"
layout(r32f) readonly uniform image2D rendered_inverse_depth;
layout(r32f) writeonly uniform image2D fringed_inverse_depth;
uniform ivec2 rendered_size;
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

// -1 for what is no depth; 0 beyond the border, where an image reads 0.
float depth_at(ivec2 pixel) {
    float found = imageLoad(rendered_inverse_depth, pixel).r;
    return found >= 0.0 && found < 1e30 ? found : -1.0;
}

void main() {
    ivec2 pixel = first_pixel();
    if (pixel.x >= rendered_size.x) return;
    float below = depth_at(pixel - ivec2(0, 1)), own = depth_at(pixel);
    for (int row = 0; row < ROWS && pixel.y < rendered_size.y; ++row, ++pixel.y) {
        float above = depth_at(pixel + ivec2(0, 1));
        float nearest = max(max(below, above), max(depth_at(pixel - ivec2(1, 0)), depth_at(pixel + ivec2(1, 0))));
        bool steps = own >= 0.0 && nearest - own > depth_tolerance * (own + depth_floor);
        imageStore(fringed_inverse_depth, pixel, vec4(steps ? nearest : own));
        below = own;
        own = above;
    }
}
