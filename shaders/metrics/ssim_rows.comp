// Filters two sRGB pictures, their squares and their product along rows by a Gaussian, for SSIM.
// In: rgba8 sRGB as words, the reference's rows and then the other's. Out: 15 floats a pixel.
// Source: Wang, Bovik, Sheikh, Simoncelli 2004, eq. 14 to 16.
#define PIXELS 2
#include "metrics/bell.glsl"
layout(local_size_x = 64, local_size_y = 1) in;
layout(std430, binding = 0) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 2) writeonly buffer Sums { vec4 sums[]; };
uniform ivec2 size;

// In bytes from the middle of the range, which keeps squares small.
vec3 bytes_of(uint word) {
    return vec3(word & 255u, word >> 8 & 255u, word >> 16 & 255u) - 127.5;
}

void main() {
    ivec2 q = ivec2(gl_GlobalInvocationID.xy) * ivec2(PIXELS, 1);
    if (q.x >= size.x || q.y >= size.y) return;
    int row = q.y * size.x;
    vec3 x[PIXELS + 2 * RADIUS], y[PIXELS + 2 * RADIUS];
    for (int k = 0; k < PIXELS + 2 * RADIUS; ++k) {
        int at = row + mirrored(q.x + k - RADIUS, size.x);
        y[k] = bytes_of(pixels[at]);
        x[k] = bytes_of(pixels[at + size.x * size.y]);
    }
    for (int n = 0; n < PIXELS; ++n) {
        vec3 sx = vec3(0.0), sy = vec3(0.0), xx = vec3(0.0), yy = vec3(0.0), xy = vec3(0.0);
        for (int k = 0; k <= 2 * RADIUS; ++k) {
            vec3 a = x[n + k], b = y[n + k], wa = bell[k] * a, wb = bell[k] * b;
            sx += wa;
            sy += wb;
            xx += wa * a;
            yy += wb * b;
            xy += wa * b;
        }
        if (q.x + n < size.x) {
            int at = 4 * (row + q.x + n);
            sums[at] = vec4(sx, xx.r);
            sums[at + 1] = vec4(sy, xx.g);
            sums[at + 2] = vec4(yy, xx.b);
            sums[at + 3] = vec4(xy, 0.0);
        }
    }
}
