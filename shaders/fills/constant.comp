// PASS 0 copies the picture and sums its covered pixels by columns of ROWS, PASS 1 computes their
// mean, PASS 2 writes it to every empty pixel.
// In: shown colour. Out: the same, covered everywhere; black if nothing was covered.
// Source: none.
#define ROWS 8
#include "lib/rows.glsl"
#include "lib/coverage.glsl"
layout(rgba16f) readonly uniform image2D warped;
layout(rgba16f) writeonly uniform image2D filled;
uniform ivec2 shown_size;
// groups: of PASS 2; the last is 0 if nothing is empty. mean: from PASS 1. sums: rgb and count of
// each column.
layout(std430, binding = 0) buffer Sums { uint groups[4]; vec4 mean; vec4 sums[]; };

#if PASS == 0
void main() {
    ivec2 p = first_pixel(), size = shown_size;
    if (p.x >= size.x) return;
    int column = p.y / ROWS * size.x + p.x;
    vec4 sum = vec4(0.0);
    bool empty = false;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        vec4 colour = imageLoad(warped, p);
        imageStore(filled, p, colour);
        sum += colour.a > HIDDEN ? vec4(colour.rgb, 1.0) : vec4(0.0);
        empty = empty || colour.a == 0.0;
    }
    sums[column] = sum;
    if (empty) groups[2] = 1u;
}
#elif PASS == 1
uniform int columns;
shared vec4 shares[GROUP_X];

// A single work group, in a fixed order, so that the same picture always has the same mean.
void main() {
    int own = int(gl_LocalInvocationID.x);
    vec4 sum = vec4(0.0);
    for (int column = own; column < columns; column += GROUP_X) sum += sums[column];
    shares[own] = sum;
    barrier();
    if (own > 0) return;
    for (int other = 1; other < GROUP_X; ++other) sum += shares[other];
    mean = vec4(sum.rgb / max(sum.a, 1.0), 1.0);
}
#else
void main() {
    ivec2 p = first_pixel(), size = shown_size;
    if (p.x >= size.x) return;
    vec4 colour = mean;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        if (imageLoad(warped, p).a == 0.0) imageStore(filled, p, colour);
    }
}
#endif
