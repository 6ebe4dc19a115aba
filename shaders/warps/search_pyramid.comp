// Builds one level of the pyramid of bounds, from rendered depth (LEVEL 1) or from the level below.
// In: rendered inverse depth. Out: bounds_of the blocks of a level, in 1/m.
// Source: Tevs, Ihrke and Seidel 2008, Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic
// Height Field Rendering, section 3.
#include "lib/pyramid.glsl"
layout(local_size_x = 64, local_size_y = 1) in;
layout(r32f) readonly uniform image2D rendered_inverse_depth;
uniform ivec2 rendered_size;
uniform ivec2 blocks, below; // of this level, and of the one below
uniform int level;

vec2 joined(vec2 a, vec2 b) {
    return vec2(min(a.x, b.x), max(a.y, b.y));
}

#if FROM_DEPTH
vec2 bounds_in(ivec2 block) {
    vec2 found = vec2(1e30, -1.0);
    for (int y = -1; y <= 4; ++y)
        for (int x = -1; x <= 4; ++x) {
            ivec2 texel = block * 4 + ivec2(x, y);
            float here = imageLoad(rendered_inverse_depth, texel).r;
            bool holds = here >= 0.0 && here < 1e30 && all(lessThan(uvec2(texel), uvec2(rendered_size)));
            found = holds ? joined(found, vec2(here)) : found;
        }
    return found;
}
#else
vec2 bounds_in(ivec2 block) {
    vec2 found = vec2(1e30, -1.0);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) found = joined(found, bounds_of[block_index(level - 1, min(block * 4 + ivec2(x, y), below - 1))]);
    return found;
}
#endif

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (block.x >= blocks.x || block.y >= blocks.y) return;
    bounds_of[block_index(level, block)] = bounds_in(block);
}
