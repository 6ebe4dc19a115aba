// What a pixel that was drawn with several samples gets of them: the mean of their linear colour
// (MEAN), or what one of them has: the inverse depth of the nearest surface (without a define), or
// the number (NUMBER) or velocity (VELOCITY) of the body that has a sample.
// In: the samples of each pixel; for depth also that of its centre, which stays where no sample
// shows a nearer surface. Out: rgba16f colour with coverage; r32f inverse depth in 1/m; r16ui
// number; rgba16f m/s with coverage.
// Source: Vulkan 1.3 specification, VkResolveModeFlagBits (the mean, one sample, or the largest).
#define GROUP_X 64 // one pixel each: llvmpipe takes twice as long over a column of eight
#define GROUP_Y 1
layout(local_size_x = GROUP_X, local_size_y = GROUP_Y) in;

#ifdef NUMBER
uniform usampler2DMS samples;
layout(r16ui) writeonly uniform uimage2D resolved;
#else
uniform sampler2DMS samples;
#if defined(MEAN) || defined(VELOCITY)
layout(rgba16f) writeonly uniform image2D resolved;
#else
layout(r32f) uniform image2D resolved;
uniform float same; // relative difference of inverse depth between two draws of the same surface
#endif
#endif
uniform int count;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(resolved);
    if (p.x >= size.x || p.y >= size.y) return;
#ifdef NUMBER
    uint found = 0u;
    for (int i = 0; i < count; ++i) found = max(found, texelFetch(samples, p, i).r);
    imageStore(resolved, p, uvec4(found));
#elif defined(MEAN)
    vec4 sum = vec4(0.0);
    for (int i = 0; i < count; ++i) sum += texelFetch(samples, p, i);
    imageStore(resolved, p, sum / count);
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
