// Scatters each rendered pixel; the last in raster order wins: row by row from the top, as in image
// files, each from left to right.
// In: rendered pixel and inverse depth. Out: shown colour; coverage 0 where nothing landed.
// Source: the painter's algorithm without sorting: what 3D warping does without occlusion (McMillan
// 1995, section 1).
#include "lib/scatter_in_order.glsl"

// 15 bits each for the row from the top and the column.
uint order_of(ivec2 rendered) {
    return (uint(rendered_size.y - 1 - rendered.y) << 15) | uint(rendered.x);
}

ivec2 rendered_of(uint order) {
    return ivec2(order & 0x7FFFu, rendered_size.y - 1 - int(order >> 15));
}
