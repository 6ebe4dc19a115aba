// Composite head-locked content over the shown picture, pixel by pixel: it is never warped.
// In: shown colour with coverage 0 or 1; the overlay, premultiplied. Out: shown colour; a hole
// stays a hole unless the overlay covers it.
// Source: Porter and Duff 1984, Compositing Digital Images (over).
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D picture;
layout(rgba16f) readonly uniform image2D overlay;
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 shown_size;

const float WHOLE = 1.0 - 1.0 / 512.0; // the least value that half floats may leave of 1

void main() {
    ivec2 p = first_pixel(), size = shown_size;
    if (p.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        vec4 behind = imageLoad(picture, p), over = imageLoad(overlay, p);
        bool covered = max(behind.a, over.a) >= WHOLE;
        imageStore(written, p, covered ? vec4(over.rgb + (1.0 - over.a) * behind.rgb, 1.0) : vec4(0.0));
    }
}
