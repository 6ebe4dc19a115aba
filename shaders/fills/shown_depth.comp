// PASS 0: the inverse depth that each rendered pixel has in the shown view, as a picture that a
// warp can carry. PASS 1: the result of the warp.
// In: rendered inverse depth in 1/m (-1: none); the carried picture. Out: rgba16f (inverse depth,
// 0, 0, coverage); r32f, -1 in holes.
// Source: McMillan and Bishop 1995 (the third row of the map is the ratio of both depths);
// docs/conventions.md.
#include "lib/rows.glsl"
#if PASS == 0
#include "lib/warp_map.glsl"
layout(r32f) readonly uniform image2D rendered_inverse_depth;
layout(rgba16f) writeonly uniform image2D here;
uniform ivec2 rendered_size;

const float LARGEST = 65504.0; // of a half float

void main() {
    ivec2 p = first_pixel(), size = rendered_size;
    if (p.x >= size.x) return;
    vec3 row = vec3(H[0].z, H[1].z, H[2].z);
    float parallax = e.z;
    for (int y = 0; y < ROWS; ++y, ++p.y) {
        if (p.y >= size.y) break;
        float rendered = imageLoad(rendered_inverse_depth, p).r;
        float ratio = dot(row, vec3(vec2(p) + 0.5, 1.0)) + parallax * rendered;
        float shown = rendered / ratio;
        bool known = rendered >= 0.0 && ratio > 0.0 && shown <= LARGEST;
        imageStore(here, p, known ? vec4(shown, 0.0, 0.0, 1.0) : vec4(0.0));
    }
}
#else
layout(rgba16f) readonly uniform image2D carried;
layout(r32f) writeonly uniform image2D shown_inverse_depth;
uniform ivec2 shown_size;

void main() {
    ivec2 p = first_pixel(), size = shown_size;
    if (p.x >= size.x) return;
    for (int y = 0; y < ROWS; ++y, ++p.y) {
        if (p.y >= size.y) break;
        vec4 found = imageLoad(carried, p);
        imageStore(shown_inverse_depth, p, vec4(found.a > 0.0 ? found.r : -1.0));
    }
}
#endif
