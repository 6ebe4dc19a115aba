// Each invocation handles ROWS pixels of one column. On llvmpipe that is 1.5 to 2 times faster than
// one pixel each, because the set-up of an invocation is paid once. Whole pixels are read by
// imageLoad, which takes llvmpipe two thirds of the time of a texelFetch and returns 0 outside the
// picture. docs/results.md has the figures.
#define GROUP_X 64
#define GROUP_Y 1
#ifndef ROWS
#define ROWS 8
#endif
layout(local_size_x = GROUP_X, local_size_y = GROUP_Y) in;

#ifdef HIDES
// The work groups with a pixel that the lens does not hide: column in the lower half, row in the upper.
layout(std430, binding = 7) readonly buffer SeenGroups { uint seen_groups[]; };

ivec2 first_pixel() {
    uint group = seen_groups[gl_WorkGroupID.x];
    ivec2 at = ivec2(group & 0xFFFFu, group >> 16) * ivec2(GROUP_X, GROUP_Y) + ivec2(gl_LocalInvocationID.xy);
    return at * ivec2(1, ROWS);
}
#else
ivec2 first_pixel() {
    return ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
}
#endif
