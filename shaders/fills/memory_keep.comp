// Keep a rendered picture, except for moving things and pixels without depth, which stay unknown.
// In: rendered colour and inverse depth; ids and velocity, 1 x 1 textures of zeros where frames
// have none. Out: the kept picture.
// Source: docs/results.md, the memory fill; this project's.
#define ROWS 4
#include "lib/rows.glsl"
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(r32f) readonly uniform image2D rendered_depth;
uniform usampler2D ids; // llvmpipe cannot read integer images
layout(rgba16f) readonly uniform image2D velocity;
layout(rgba16f) writeonly uniform image2D kept_colour;
layout(r32f) writeonly uniform image2D kept_depth;
uniform ivec2 rendered_size;

void main() {
    ivec2 p = first_pixel(), size = rendered_size;
    if (p.x >= size.x) return;
    ivec2 ids_end = textureSize(ids, 0) - 1;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        vec4 colour = imageLoad(rendered_colour, p);
        float depth = imageLoad(rendered_depth, p).r;
        bool stands = texelFetch(ids, min(p, ids_end), 0).r == 0u && imageLoad(velocity, p).a == 0.0;
        bool known = depth >= 0.0 && depth < 1e30 && colour.a >= 0.5 && stands;
        imageStore(kept_colour, p, known ? vec4(colour.rgb / colour.a, 1.0) : vec4(0.0));
        imageStore(kept_depth, p, vec4(known ? depth : -1.0));
    }
}
