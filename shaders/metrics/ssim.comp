// Filters along columns what ssim_rows.comp has filtered along rows, and compares both pictures.
// In: 4 floats a channel. Out: 1 - SSIM of each pixel, the mean of its channels: exactly 0 for
// equal pictures.
// Source: Wang, Bovik, Sheikh, Simoncelli 2004, eq. 13; both factors as 1 - what they lack, by the
// variance of the difference.
#define ROWS 4
#include "metrics/bell.glsl"
layout(local_size_x = 64, local_size_y = 1) in;
layout(rgba32f, binding = 2) readonly uniform image2D between; // a channel each beside and below size.y
layout(r32f, binding = 3) writeonly uniform image2D map;
uniform ivec2 size;

const float C1 = 6.5025, C2 = 58.5225; // (0.01 * 255)^2, (0.03 * 255)^2

float lacking(vec4 mean) {
    vec2 both = vec2(mean.x, mean.x - mean.y);
    float rest = (mean.z - mean.y * mean.y) / (mean.w - dot(both, both) + C2);
    both += 127.5;
    float light = mean.y * mean.y / (dot(both, both) + C1);
    return light + rest - light * rest;
}

void main() {
    ivec2 q = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
    if (q.x >= size.x || q.y >= size.y) return;
    vec4 means[ROWS][3];
    for (int n = 0; n < ROWS; ++n)
        for (int c = 0; c < 3; ++c) means[n][c] = vec4(0.0);
    for (int k = 0; k < ROWS + 2 * RADIUS; ++k) {
        ivec2 at = ivec2(q.x, size.y + mirrored(q.y + k - RADIUS, size.y));
        vec4 red = imageLoad(between, at), green = imageLoad(between, at + ivec2(size.x, 0));
        vec4 blue = imageLoad(between, at + ivec2(0, size.y));
        for (int n = 0; n < ROWS; ++n) {
            if (k < n || k - n > 2 * RADIUS) continue;
            means[n][0] += bell[k - n] * red;
            means[n][1] += bell[k - n] * green;
            means[n][2] += bell[k - n] * blue;
        }
    }
    for (int n = 0; n < ROWS; ++n) {
        float lacks = lacking(means[n][0]) + lacking(means[n][1]) + lacking(means[n][2]);
        if (q.y + n < size.y) imageStore(map, q + ivec2(0, n), vec4(lacks / 3.0));
    }
}
