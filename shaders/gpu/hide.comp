// Blacken the pixels of a shown picture that the lens hides. Their coverage is next to nothing, which
// weighs nothing beside what is seen, and is no hole to fill.
// In: the seen rows. Out: colour and coverage (and inverse depth, -1) of the others.
// Source: none.
#define ROWS 8 // those of a gather warp, whose groups it completes
#include "lib/rows.glsl"
#include "lib/coverage.glsl"
layout(rgba16f) writeonly uniform image2D colour;
#if WITH_DEPTH
layout(r32f) writeonly uniform image2D depth;
#endif
uniform ivec2 size;
uniform sampler2D seen_rows; // as wide as the picture, one texel high: in each column the rows from x up to y

void main() {
    ivec2 p = first_pixel();
    if (p.x >= size.x) return;
    ivec2 seen = ivec2(texelFetch(seen_rows, ivec2(p.x, 0), 0).xy);
    int end = min(p.y + ROWS, size.y);
    while (p.y < end) {
        if (p.y >= seen.x && p.y < seen.y) {
            p.y = seen.y;
            continue;
        }
        imageStore(colour, p, vec4(0.0, 0.0, 0.0, HIDDEN));
#if WITH_DEPTH
        imageStore(depth, p, vec4(-1.0));
#endif
        ++p.y;
    }
}
