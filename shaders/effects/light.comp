// Multiplies the light that is shown with the albedo that the client draws at the same pose, and
// adds what shines there.
// In: shown light, albedo with what shines, and that alone if any, whole pixels. Out: linear colour,
// coverage as the light's.
// Source: Barrow and Tenenbaum 1978, Recovering Intrinsic Scene Characteristics from Images.
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D light;
layout(rgba16f) readonly uniform image2D albedo;
layout(rgba16f) readonly uniform image2D emitted;
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 shown_size;
uniform bool shines;

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 p = first + ivec2(0, row);
        if (p.y >= shown_size.y) break;
        vec4 falling = imageLoad(light, p);
        vec3 own = shines && falling.a > 0.0 ? imageLoad(emitted, p).rgb : vec3(0.0);
        imageStore(written, p, vec4(falling.rgb * max(imageLoad(albedo, p).rgb - own, 0.0) + own, falling.a));
    }
}
