// Draw the warped mirrored world into the shown picture, where the warped surfaces are mirrors.
// In: the shown picture, its surfaces, the reflections now. Out: the shown picture with
// reflections.
// Source: lib/reflect.glsl.
#include "lib/rows.glsl"
#include "lib/reflect.glsl"
layout(rgba16f) readonly uniform image2D picture;
layout(rgba16f) readonly uniform image2D surface;
layout(rgba16f) writeonly uniform image2D written;
#ifdef GLOSSY
layout(r32f) readonly uniform image2D seen_inverse_depth;
#endif
uniform ivec2 shown_size;

void main() {
    ivec2 p = first_pixel(), size = shown_size;
    if (p.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        vec4 base = imageLoad(picture, p), what = imageLoad(surface, p);
        float inverse_depth = -1.0;
#ifdef GLOSSY
        inverse_depth = imageLoad(seen_inverse_depth, p).r;
#endif
        if (what.r > 0.0 && base.a > 0.0) base = with_reflection(vec2(p) + 0.5, base, what, texelFetch(seen, p, 0), inverse_depth);
        imageStore(written, p, base);
    }
}
