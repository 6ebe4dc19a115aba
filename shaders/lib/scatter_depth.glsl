// The index of a rendered pixel, for its key in lib/depth_key.glsl.
#include "lib/depth_key.glsl"

uint source_of(ivec2 rendered) {
    return uint(rendered.y) * uint(rendered_size.x) + uint(rendered.x);
}
