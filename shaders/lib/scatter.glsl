// Where rendered pixels land in the shown picture; runs `visit` for every rendered pixel. A
// rendered pixel whose inverse depth is negative, NaN or infinite has no depth and lands nowhere.
#include "lib/scatter_sizes.glsl"
#include "lib/warp_map.glsl"
layout(r32f) readonly uniform image2D rendered_inverse_depth;

const float LARGEST = 3.402823466e38; // the largest finite float32

struct Landing {
    bool lands;
    ivec2 pixel;
    uint slot; // index of the pixel in the shown picture
    float shown_inverse_depth;
};

// base: H times the rendered pixel's centre.
Landing landing(ivec2 rendered, vec3 base) {
    float inverse_depth = imageLoad(rendered_inverse_depth, rendered).r;
    // precise: two passes must compute the same bits, whatever the compiler might contract.
    precise vec3 q = base + e * inverse_depth;
    precise vec2 p = q.xy / q.z;
    precise float shown_inverse_depth = inverse_depth / q.z;
    Landing to;
    to.lands = inverse_depth >= 0.0 && inverse_depth <= LARGEST && q.z > 0.0 && inside(p, shown_size);
    to.pixel = ivec2(p);
    to.slot = uint(to.pixel.y) * uint(shown_size.x) + uint(to.pixel.x);
    to.shown_inverse_depth = shown_inverse_depth;
    return to;
}

void visit(ivec2 rendered, vec3 base);

// first: the lowest pixel of this invocation, inside the picture on x.
void visit_all(ivec2 first) {
    // precise: as in landing(), whose own `precise` does not reach its caller.
    precise vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= rendered_size.y) break;
        precise vec3 here = base + H[1] * float(row);
        visit(first + ivec2(0, row), here);
    }
}
