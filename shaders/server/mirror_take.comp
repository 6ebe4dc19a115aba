// Store the reflection in one mirror, where a ray meets that mirror before all others; other pixels
// keep theirs.
// In: the world behind the mirror, in the eye's own pixels. Out: the reflections of all mirrors,
// rgba16f; their inverse depth, -1 for none.
// Source: Akenine-Moeller et al. 2018, Real-Time Rendering, 11.6.2 (planar reflections).
#include "lib/rows.glsl"
#include "lib/mirrors.glsl"
layout(rgba16f) writeonly uniform image2D seen_colour;
layout(r32f) writeonly uniform image2D seen_inverse_depth;
layout(rgba16f) readonly uniform image2D behind_colour;
layout(r32f) readonly uniform image2D behind_inverse_depth;
uniform ivec2 from, to; // the pixels to visit, `to` excluded
uniform int taken;            // the mirror

void main() {
    ivec2 p = first_pixel() + from;
    if (p.x >= to.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= to.y) break;
        if (meet_mirror(ray_of(vec2(p) + 0.5)).mirror == taken) {
            imageStore(seen_colour, p, imageLoad(behind_colour, p));
            imageStore(seen_inverse_depth, p, imageLoad(behind_inverse_depth, p));
        }
    }
}
