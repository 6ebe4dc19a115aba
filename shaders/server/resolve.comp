// What a pixel that was drawn with several samples gets of them: the mean of their linear colour.
// In: the samples of each pixel. Out: rgba16f colour with coverage.
// Source: Vulkan 1.3 specification, VkResolveModeFlagBits (the mean).
#define GROUP_X 64 // one pixel each: llvmpipe takes twice as long over a column of eight
#define GROUP_Y 1
layout(local_size_x = GROUP_X, local_size_y = GROUP_Y) in;

uniform sampler2DMS samples;
layout(rgba16f) writeonly uniform image2D resolved;
uniform int count;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(resolved);
    if (p.x >= size.x || p.y >= size.y) return;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < count; ++i) sum += texelFetch(samples, p, i);
    imageStore(resolved, p, sum / count);
}
