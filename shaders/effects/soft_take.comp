// Take what deforms out of a rendered picture: it leaves holes.
// In: rendered colour and inverse depth, and the inverse depth of what deforms at the instant the
// picture was drawn, -1 where nothing does. Out: colour and inverse depth with holes.
// Source: this project's; the deforming mesh itself says which pixels are its own.
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(r32f) readonly uniform image2D rendered_inverse_depth;
layout(r32f) readonly uniform image2D body_inverse_depth;
layout(rgba16f) writeonly uniform image2D left_colour;
layout(r32f) writeonly uniform image2D left_inverse_depth;
uniform ivec2 rendered_size;
uniform float same; // relative difference up to which two inverse depths are one surface

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x) return;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 p = first + ivec2(0, row);
        if (p.y >= rendered_size.y) break;
        float r = imageLoad(rendered_inverse_depth, p).r, body = imageLoad(body_inverse_depth, p).r;
        bool taken = body >= 0.0 && r <= body * (1.0 + same);
        imageStore(left_colour, p, taken ? vec4(0.0) : imageLoad(rendered_colour, p));
        imageStore(left_inverse_depth, p, vec4(taken ? -1.0 : r));
    }
}
