// Draw reflections into a picture, where it shows mirrors.
// In: the picture, its mirrors' properties, the reflections. Out: the picture, in place.
// Source: lib/reflect.glsl.
#define GLOSSY
#include "lib/rows.glsl"
#include "lib/reflect.glsl"
layout(rgba16f) uniform image2D picture;
layout(rgba16f) readonly uniform image2D surface;
layout(r32f) readonly uniform image2D seen_inverse_depth;
uniform ivec2 size;

void main() {
    ivec2 p = first_pixel();
    if (p.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        vec4 what = imageLoad(surface, p);
        if (what.r > 0.0) {
            vec4 own = texelFetch(seen, p, 0);
            imageStore(picture, p, with_reflection(vec2(p) + 0.5, imageLoad(picture, p), what, own, imageLoad(seen_inverse_depth, p).r));
        }
    }
}
