// One bilinear look into the late picture. Its colour is premultiplied by coverage there (a hole is 0, 0, 0, 0), so holes
// never bleed: what is covered is averaged, and the result is covered where the weight of covered pixels is at least a half.
uniform sampler2D late_colour;
uniform ivec2 late_size;
uniform vec2 late_pixel; // 1 / late_size

vec4 covered_average(vec2 p) {
    vec4 sum = textureLod(late_colour, p * late_pixel, 0.0);
    return sum.a >= 0.5 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
