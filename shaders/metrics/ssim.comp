// Filters along columns what ssim_rows.comp has filtered along rows, and compares both pictures.
// In: 15 floats a pixel. Out: 1 - SSIM of each pixel, the mean of its channels: exactly 0 for equal
// pictures.
// Source: Wang, Bovik, Sheikh, Simoncelli 2004, eq. 13; both factors as 1 - what they lack.
#define ROWS 8
#include "metrics/bell.glsl"
layout(local_size_x = 64, local_size_y = 1) in;
layout(rgba32f, binding = 2) readonly uniform image2D between; // from size.y on, four parts of that size
layout(r32f, binding = 3) writeonly uniform image2D map;
uniform ivec2 size;

const float C1 = 6.5025, C2 = 58.5225; // (0.01 * 255)^2, (0.03 * 255)^2

void main() {
    ivec2 q = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
    if (q.x >= size.x || q.y >= size.y) return;
    vec4 found[ROWS][4];
    for (int n = 0; n < ROWS; ++n)
        for (int part = 0; part < 4; ++part) found[n][part] = vec4(0.0);
    for (int k = 0; k < ROWS + 2 * RADIUS; ++k) {
        ivec2 at = ivec2(q.x, size.y + mirrored(q.y + k - RADIUS, size.y));
        vec4 one = imageLoad(between, at), two = imageLoad(between, at + ivec2(size.x, 0));
        vec4 three = imageLoad(between, at + ivec2(0, size.y)), four = imageLoad(between, at + size);
        for (int n = 0; n < ROWS; ++n) {
            if (k < n || k - n > 2 * RADIUS) continue;
            found[n][0] += bell[k - n] * one;
            found[n][1] += bell[k - n] * two;
            found[n][2] += bell[k - n] * three;
            found[n][3] += bell[k - n] * four;
        }
    }
    for (int n = 0; n < ROWS; ++n) {
        vec3 mx = found[n][0].xyz, my = found[n][1].xyz;
        vec3 vx = vec3(found[n][0].w, found[n][1].w, found[n][2].w) - mx * mx;
        vec3 vy = found[n][2].xyz - my * my, vxy = found[n][3].xyz - mx * my;
        vec3 apart = mx - my;
        mx += 127.5;
        my += 127.5;
        vec3 light = apart * apart / (mx * mx + my * my + C1), rest = (vx + vy - 2.0 * vxy) / (vx + vy + C2);
        vec3 lacks = light + rest - light * rest;
        if (q.y + n < size.y) imageStore(map, q + ivec2(0, n), vec4((lacks.x + lacks.y + lacks.z) / 3.0));
    }
}
