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

ivec2 first_pixel() {
    return ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
}
