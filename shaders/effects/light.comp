// Multiplies the light that is shown with the albedo that the client draws at the same pose.
// In: shown light and albedo, whole pixels. Out: linear colour, coverage as the light's.
// Source: Barrow and Tenenbaum 1978, Recovering Intrinsic Scene Characteristics from Images.
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D light;
layout(rgba16f) readonly uniform image2D albedo;
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 shown_size;

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 p = first + ivec2(0, row);
        if (p.y >= shown_size.y) break;
        vec4 falling = imageLoad(light, p);
        imageStore(written, p, vec4(falling.rgb * imageLoad(albedo, p).rgb, falling.a));
    }
}
