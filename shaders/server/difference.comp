// The picture less that of a simplified scene, in bytes of the display, for a client that draws the
// simplified one itself.
// In: full and simplified pictures of one view, whole pixels. Out: the light of (d + 1) / 2, where d
// is the difference of the bytes over 255; coverage 1.
// Source: Levoy 1995, Polygon-Assisted JPEG and MPEG Compression of Synthetic Images.
#include "lib/rows.glsl"
#include "lib/display_bytes.glsl"
layout(rgba16f) readonly uniform image2D full;
layout(rgba16f) readonly uniform image2D simplified;
layout(rgba16f) writeonly uniform image2D difference;
uniform ivec2 rendered_size;

void main() {
    ivec2 p = first_pixel();
    if (p.x >= rendered_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= rendered_size.y) break;
        vec3 d = bytes_of(imageLoad(full, p).rgb) - bytes_of(imageLoad(simplified, p).rgb);
        imageStore(difference, p, vec4(light_of((d + 255.0) / 510.0), 1.0));
    }
}
