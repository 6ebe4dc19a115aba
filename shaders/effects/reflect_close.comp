// Close the holes of a picture: PASS 0 halves it, weighted by coverage, PASS 1 fills gaps from the
// next coarser level.
// In: premultiplied colour, coverage in alpha. Out: PASS 0 the level of half the size; PASS 1 the
// same level, in place, without holes.
// Source: Gortler et al. 1996, The Lumigraph, 3.4 (pull-push).
#include "lib/rows.glsl"
#if PASS == 0
layout(rgba16f) readonly uniform image2D finer;
layout(rgba16f) writeonly uniform image2D level;
#else
layout(rgba16f) uniform image2D level;
uniform sampler2D coarser;
uniform vec2 coarser_pixel; // half of 1 / its size
#endif
uniform ivec2 level_size;

void visit(ivec2 p) {
#if PASS == 0
    ivec2 at = 2 * p;
    vec4 sum = imageLoad(finer, at) + imageLoad(finer, at + ivec2(1, 0)) + imageLoad(finer, at + ivec2(0, 1)) + imageLoad(finer, at + 1);
    imageStore(level, p, sum.a > 1.0 ? sum / sum.a : sum); // one covered pixel of four is enough
#else
    vec4 own = imageLoad(level, p);
    if (own.a < 1.0) {
        vec4 below = textureLod(coarser, (vec2(p) + 0.5) * coarser_pixel, 0.0);
        below = below.a > 0.0 ? below / below.a : vec4(0.0);
        imageStore(level, p, own + (1.0 - own.a) * below);
    }
#endif
}

void main() {
    ivec2 p = first_pixel(), size = level_size;
    if (p.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= size.y) break;
        visit(p);
    }
}
