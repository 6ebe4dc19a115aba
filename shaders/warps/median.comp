// Computes the (lower) median inverse depth over a grid of GRID x GRID samples of the rendered
// picture, one work group, no read-back.
// In: rendered inverse depth, -1 where there is none. Out: 1/m; 0 if nothing has depth.
// Source: selection by bisection on the bits of non-negative floats, which sort as unsigned
// integers (abs: -0.0 sorts as 0).
#define GRID 64
#define THREADS 256
#define FLOAT_MAX 3.4028234e38
layout(local_size_x = THREADS) in;
uniform sampler2D rendered_inverse_depth;
uniform ivec2 rendered_size;
layout(std430, binding = 0) writeonly buffer Plane { float plane_inverse_depth; };
shared uint at_most;
shared uint with_depth;

void main() {
    const int each = GRID * GRID / THREADS;
    float mine[each];
    if (gl_LocalInvocationIndex == 0u) with_depth = 0u;
    barrier();
    for (int i = 0; i < each; ++i) {
        int k = int(gl_LocalInvocationIndex) + i * THREADS;
        ivec2 cell = ivec2(k % GRID, k / GRID);
        mine[i] = texelFetch(rendered_inverse_depth, (2 * cell + 1) * rendered_size / (2 * GRID), 0).r;
        if (!(mine[i] <= FLOAT_MAX)) mine[i] = -1.0; // Inf and NaN count as no depth
        if (mine[i] >= 0.0) atomicAdd(with_depth, 1u);
    }
    barrier();
    uint rank = (with_depth + 1u) / 2u;
    uint low = 0u, high = 0x7F7FFFFFu; // 0 and the largest finite float
    for (int step = 0; step < 31; ++step) {
        uint middle = low + (high - low) / 2u;
        if (gl_LocalInvocationIndex == 0u) at_most = 0u;
        barrier();
        for (int i = 0; i < each; ++i)
            if (mine[i] >= 0.0 && floatBitsToUint(abs(mine[i])) <= middle) atomicAdd(at_most, 1u);
        barrier();
        if (at_most >= rank) high = middle;
        else low = middle + 1u;
        barrier();
    }
    if (gl_LocalInvocationIndex == 0u) plane_inverse_depth = with_depth == 0u ? 0.0 : uintBitsToFloat(low);
}
