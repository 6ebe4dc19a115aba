// The index of a rendered pixel, for its key in lib/depth_key.glsl.
// In: a rendered pixel. Out: its index.
// Source: Schuetz et al. 2021 (arXiv 2104.07526), section 3.
#include "lib/depth_key.glsl"

uint source_of(ivec2 rendered) {
    return uint(rendered.y) * uint(rendered_size.x) + uint(rendered.x);
}
