// How far away the veil of a pixel is: the nearest sheet that is not hidden, where there is none the
// nearest of all.
// In: rg32f, inverse depth in 1/m of both, -1 for none. Out: r32f, one of them.
// Source: none; a choice for each pixel.
#include "lib/rows.glsl"
layout(rg32f) readonly uniform image2D nearest;
layout(r32f) writeonly uniform image2D inverse_depth;

void main() {
    ivec2 p = first_pixel(), size = imageSize(inverse_depth);
    if (p.x >= size.x) return;
    for (int row = 0; row < ROWS && p.y < size.y; ++row, ++p.y) {
        vec2 found = imageLoad(nearest, p).rg;
        imageStore(inverse_depth, p, vec4(found.r >= 0.0 ? found.r : found.g));
    }
}
