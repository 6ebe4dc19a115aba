// Lay one panel over the shown picture, in place: the only sample that it gets, at the shown pose.
// In: shown pixel; the picture with coverage 0 or 1. Out: the same; a hole stays one unless the panel
// covers it. With OCCLUDED, what is nearer in the picture hides the panel.
// Source: Porter and Duff 1984, Compositing Digital Images (over); lib/panel_sample.glsl.
#include "lib/rows.glsl"
#include "lib/coverage.glsl"
#include "lib/panel_sample.glsl"
layout(rgba16f) uniform image2D picture;
#ifdef OCCLUDED
layout(r32f) readonly uniform image2D shown_inverse_depth;
uniform float nearer; // a little above 1: a panel that lies on a surface is not hidden by it
#endif
uniform ivec4 box; // first pixel and the one past the last
uniform float rows; // of the shown picture
// To q at the time t of a row: at_first + t (linear + t square), as in to_shown.glsl.
uniform mat3 at_first, linear, square;

const float WHOLE = 1.0 - 1.0 / 512.0; // the least value that half floats may leave of 1

void main() {
    ivec2 p = first_pixel() + box.xy;
    if (p.x >= box.z) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= box.w) break;
        vec4 behind = imageLoad(picture, p);
        if (behind.a > 0.0 && behind.a <= HIDDEN) continue;
        float t = 1.0 - (float(p.y) + 0.5) / rows;
        mat3 map = at_first + t * (linear + t * square);
        vec3 q = map * vec3(vec2(p) + 0.5, 1.0);
#ifdef OCCLUDED
        if (q.z * nearer < imageLoad(shown_inverse_depth, p).r) continue;
#endif
        vec4 over = panel_colour(q, map[0], map[1]);
        if (over.a <= 0.0) continue;
        bool covered = max(behind.a, over.a) >= WHOLE;
        imageStore(picture, p, covered ? vec4(over.rgb + max(1.0 - over.a, 0.0) * behind.rgb, 1.0) : behind);
    }
}
