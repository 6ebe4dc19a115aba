// Filters two sRGB pictures along rows: what the eye tells apart, and edges and points, for FLIP.
// In: rgba8 sRGB as words, the reference's rows and then the other's. Out: 7 floats a pixel.
// Source: Andersson et al. 2020, FLIP, eq. 2 to 4 and 10; IEC 61966-2-1 (sRGB).
#define PIXELS 4
layout(local_size_x = 64, local_size_y = 1) in;
layout(std430, binding = 0) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 1) readonly buffer Light { float light[]; }; // of each byte
layout(std430, binding = 2) writeonly buffer Seen { vec4 seen[]; }; // Y, Cx, and both parts of Cz
layout(std430, binding = 3) writeonly buffer Shapes { vec4 shapes[]; }; // smooth, edge, point
uniform ivec2 size; // of one picture
uniform mat3 white_from_rgb; // XYZ over that of white
uniform vec4 sight[2 * RADIUS + 1]; // weights: Y, Cx, both parts of Cz
uniform vec3 shape[2 * RADIUS + 1]; // smooth, edge, point

void main() {
    ivec2 q = ivec2(gl_GlobalInvocationID.xy) * ivec2(PIXELS, 1);
    if (q.x >= size.x || q.y >= 2 * size.y) return;
    int row = q.y * size.x;
    vec3 around[PIXELS + 2 * RADIUS];
    for (int k = 0; k < PIXELS + 2 * RADIUS; ++k) {
        uint word = pixels[row + clamp(q.x + k - RADIUS, 0, size.x - 1)];
        vec3 rgb = vec3(light[word & 255u], light[word >> 8 & 255u], light[word >> 16 & 255u]);
        vec3 w = white_from_rgb * rgb;
        around[k] = vec3(116.0 * w.y - 16.0, 500.0 * (w.x - w.y), 200.0 * (w.y - w.z));
    }
    for (int n = 0; n < PIXELS; ++n) {
        vec4 colour = vec4(0.0);
        vec3 formed = vec3(0.0);
        for (int k = 0; k <= 2 * RADIUS; ++k) {
            colour += sight[k] * around[n + k].xyzz;
            formed += shape[k] * ((around[n + k].x + 16.0) / 116.0);
        }
        if (q.x + n < size.x) {
            seen[row + q.x + n] = colour;
            shapes[row + q.x + n] = vec4(formed, 0.0);
        }
    }
}
