// Copy a buffer, 16 bytes at a time: a known pass that shows whether timers measure.
// In: buffer 0, `count` blocks. Out: buffer 1, the same blocks.
// Source: the copy kernel of McCalpin 1995, Memory Bandwidth and Machine Balance (STREAM).
#include "lib/rows.glsl"
layout(std430, binding = 0) readonly buffer From { uvec4 from[]; };
layout(std430, binding = 1) writeonly buffer To { uvec4 to[]; };
uniform int count;
uniform int width; // blocks in a row of the dispatch; neighbouring invocations touch neighbouring blocks

void main() {
    ivec2 p = first_pixel();
    if (p.x >= width) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        int i = p.y * width + p.x;
        if (i < count) to[i] = from[i];
    }
}
