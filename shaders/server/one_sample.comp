// What a pixel that was drawn with several samples gets of one of them, never a mean: the inverse
// depth of the nearest surface, or the motion of the body that has a sample: its number (NUMBER) or
// its velocity (VELOCITY). Without either define depth.
// In: the samples of each pixel; for depth also that of its centre, which stays where no sample
// shows a nearer surface. Out: r32f inverse depth in 1/m; r16ui number; rgba16f m/s with coverage.
// Source: Vulkan 1.3 specification, VkResolveModeFlagBits (one sample, or the largest, not the mean).
#include "lib/rows.glsl"
#ifdef NUMBER
uniform usampler2DMS samples;
layout(r16ui) writeonly uniform uimage2D resolved;
#elif defined(VELOCITY)
uniform sampler2DMS samples;
layout(rgba16f) writeonly uniform image2D resolved;
#else
uniform sampler2DMS samples;
layout(r32f) uniform image2D resolved;
uniform float same; // relative difference of inverse depth between two draws of the same surface
#endif
uniform int count;

void main() {
    ivec2 p = first_pixel(), size = imageSize(resolved);
    if (p.x >= size.x) return;
    for (int row = 0; row < ROWS && p.y < size.y; ++row, ++p.y) {
#ifdef NUMBER
        uint found = 0u;
        for (int i = 0; i < count; ++i) found = max(found, texelFetch(samples, p, i).r);
        imageStore(resolved, p, uvec4(found));
#elif defined(VELOCITY)
        vec4 found = vec4(0.0);
        for (int i = 0; i < count && found.a == 0.0; ++i) found = texelFetch(samples, p, i);
        imageStore(resolved, p, found);
#else
        float centre = imageLoad(resolved, p).r, nearest = centre;
        for (int i = 0; i < count; ++i) nearest = max(nearest, texelFetch(samples, p, i).r);
        if (nearest - centre > same * nearest) imageStore(resolved, p, vec4(nearest));
#endif
    }
}
