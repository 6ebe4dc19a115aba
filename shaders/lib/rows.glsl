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
// The strips, STRIP columns wide and ROWS high, with a pixel that the lens does not hide: column in
// the lower half, row in the upper. Narrower than a work group they follow the outline more closely,
// and wide enough for what llvmpipe runs at a time.
const int STRIP = 16;
layout(std430, binding = 7) readonly buffer SeenStrips { uint seen_strips[]; };

ivec2 first_pixel() {
    uint strip = seen_strips[gl_GlobalInvocationID.x / uint(STRIP)];
    return ivec2(strip & 0xFFFFu, strip >> 16) * ivec2(STRIP, ROWS) + ivec2(gl_LocalInvocationID.x % uint(STRIP), 0);
}
#else
ivec2 first_pixel() {
    return ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
}
#endif
