// The depth-tested scatter in one pass over the rendered pixels: depth and source in one 64-bit
// key. Same winners as forward.comp.
// In: rendered pixel and inverse depth. Out: shown colour; coverage 0 where nothing landed.
// Source: Schuetz et al. 2021 (arXiv 2104.07526), section 3; GL_NV_shader_atomic_int64.
//
// PASS 0 keeps the largest key of each shown pixel: above depth_key, below the complement of the
// index, so that of equal depth keys the lowest index wins. PASS 1 copies the colours, and needs no
// 64-bit arithmetic.
#extension GL_ARB_gpu_shader_int64 : require
#extension GL_NV_shader_atomic_int64 : require
#include "lib/scatter_sizes.glsl"
#if PASS == 0
#include "lib/scatter.glsl"
#include "lib/scatter_depth.glsl"
layout(std430, binding = 0) buffer Keys { uint64_t key_of[]; };

void visit(ivec2 rendered, vec3 base) {
    Landing to = landing(rendered, base);
    if (!to.lands) return;
    uint source = source_of(rendered);
    uint key = depth_key(to.shown_inverse_depth, rendered, source);
    atomicMax(key_of[to.slot], (uint64_t(key) << 32) | uint64_t(~source));
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x) return;
    visit_all(first);
}
#else
#include "lib/scatter_resolve.glsl"
layout(std430, binding = 0) buffer Keys { uvec2 key_of[]; };

ivec2 winner(uint slot) {
    uvec2 key = key_of[slot];
    key_of[slot] = uvec2(0u);
    uint source = ~key.x;
    return key.y == 0u ? ivec2(-1) : ivec2(source % uint(rendered_size.x), source / uint(rendered_size.x));
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    resolve_all(first);
}
#endif
