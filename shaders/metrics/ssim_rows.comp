// Filters two sRGB pictures, their squares and their product along rows by a Gaussian, for SSIM.
// In: rgba8 sRGB, the reference's rows and then the other's. Out: 15 floats a pixel.
// Source: Wang, Bovik, Sheikh, Simoncelli 2004, eq. 14 to 16.
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
            ivec2 at = q + ivec2(n, size.y);
            imageStore(between, at, vec4(sx, xx.r));
            imageStore(between, at + ivec2(size.x, 0), vec4(sy, xx.g));
            imageStore(between, at + ivec2(0, size.y), vec4(yy, xx.b));
            imageStore(between, at + size, vec4(xy, 0.0));
        }
    }
}
