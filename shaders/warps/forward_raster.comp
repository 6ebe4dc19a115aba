// Scatters each drawn pixel; the later one in raster order stays: row by row from the top, as in image files, each from left to right.
// In: rendered pixel and inverse depth. Out: shown colour; coverage 0 where nothing landed.
// Source: the painter's algorithm without sorting: what 3D warping does before it minds occlusion (McMillan 1995, section 1).
#include "lib/scatter_in_order.glsl"

// 15 bits each for the row from the top and the column.
uint order_of(ivec2 drawn) {
    return (uint(rendered_size.y - 1 - drawn.y) << 15) | uint(drawn.x);
}

ivec2 drawn_of(uint order) {
    return ivec2(order & 0x7FFFu, rendered_size.y - 1 - int(order >> 15));
}
