// Remove moving things from the rendered picture, leaving holes; everything else stays bit for bit.
// List their pixels.
// In: rendered colour and inverse depth, ids, velocities. Out: colour and inverse depth of what is
// static; a bit for each moving pixel, ROWS rows of one column to a word.
// Source: the object ids and motion vectors of a frame as XR_FB_space_warp and
// XR_EXT_frame_synthesis have them.
#define ROWS 32
#include "lib/rows.glsl"
#include "effects/motion.glsl"
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(rgba16f) writeonly uniform image2D still_colour;
layout(r32f) writeonly uniform image2D still_inverse_depth;
layout(std430, binding = 1) writeonly buffer Masks { uint masks[]; };

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x || first.y >= rendered_size.y) return;
    uint mask = 0u;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.y >= rendered_size.y) break;
        float r = imageLoad(rendered_inverse_depth, pixel).r;
        vec4 colour = imageLoad(rendered_colour, pixel);
        bool moves = is_depth(r) && key_of(pixel) != 0u;
        mask |= uint(moves) << uint(row);
        imageStore(still_colour, pixel, moves ? vec4(0.0) : colour);
        imageStore(still_inverse_depth, pixel, vec4(moves ? -1.0 : r));
    }
    masks[(first.y / ROWS) * rendered_size.x + first.x] = mask;
}
