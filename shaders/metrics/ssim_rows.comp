// Filters two sRGB pictures, their difference, its square and their squares along rows by a
// Gaussian, for SSIM.
// In: rgba8 sRGB, the reference's rows and then the other's. Out: 4 floats a channel.
// Source: Wang, Bovik, Sheikh, Simoncelli 2004, eq. 14 to 16, of the difference in place of the
// product.
#define PIXELS 2
#include "metrics/bell.glsl"
layout(local_size_x = 64, local_size_y = 1) in;
layout(rgba8ui, binding = 0) readonly uniform uimage2D pixels;
layout(rgba32f, binding = 2) writeonly uniform image2D between; // below: the reference's rows for FLIP
uniform ivec2 size;

// In bytes from the middle of the range, which keeps squares small.
vec3 bytes_at(ivec2 p) {
    return vec3(imageLoad(pixels, p).rgb) - 127.5;
}

void main() {
    ivec2 q = ivec2(gl_GlobalInvocationID.xy) * ivec2(PIXELS, 1);
    if (q.x >= size.x || q.y >= size.y) return;
    vec3 x[PIXELS + 2 * RADIUS], y[PIXELS + 2 * RADIUS];
    for (int k = 0; k < PIXELS + 2 * RADIUS; ++k) {
        ivec2 at = ivec2(mirrored(q.x + k - RADIUS, size.x), q.y);
        y[k] = bytes_at(at);
        x[k] = bytes_at(at + ivec2(0, size.y));
    }
    for (int c = 0; c < 3; ++c) {
        vec4 sums[PIXELS];
        for (int n = 0; n < PIXELS; ++n) sums[n] = vec4(0.0);
        for (int k = 0; k < PIXELS + 2 * RADIUS; ++k) {
            float a = x[k][c], b = y[k][c], apart = a - b;
            vec4 here = vec4(a, apart, apart * apart, a * a + b * b);
            for (int n = 0; n < PIXELS; ++n)
                if (k >= n && k - n <= 2 * RADIUS) sums[n] += bell[k - n] * here;
        }
        ivec2 at = q + ivec2(c & 1, 1 + (c >> 1)) * size;
        for (int n = 0; n < PIXELS; ++n)
            if (q.x + n < size.x) imageStore(between, at + ivec2(n, 0), sums[n]);
    }
}
