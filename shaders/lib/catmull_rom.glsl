// One sample of a picture by the Catmull-Rom cubic along the row and the column of texels that are
// nearest to the place: four texels around it, and four beyond. It keeps detail that a bilinear
// sample averages away. The includer has `vec4 colour_texel(ivec2 texel)`.
//
// The cubic is the bilinear sample and a correction along each axis. The sample stays between the
// four texels, so nothing rings at edges. (Without that a chain of warps ends 3 to 4 dB lower.) With
// all 4 x 4 texels pictures are no better. Where one of the eight is not covered the sample is
// bilinear, and its coverage is that of the bilinear sample always.
// Source: Catmull and Rom 1974, A Class of Local Interpolating Splines; Keys 1981, Cubic
// Convolution Interpolation for Digital Image Processing (a = -1/2).

// Pixels: nearer to a texel's centre than this is on it, so that a picture that moves by whole
// pixels keeps its last bits. A GPU's sampler rounds places four times as coarsely.
const float ON_A_CENTRE = 1.0 / 1024.0;

// What the cubic through four texels adds to the line between the inner two, at t of the way from the
// second: weights of all four.
vec4 beside_the_line(float t) {
    float u = 1.0 - t, half_way = 0.5 * t * u;
    return half_way * vec4(-u, 2.0 - 3.0 * t, 3.0 * t - 1.0, -t);
}

vec4 catmull_rom(vec2 p, ivec2 size) {
    vec2 at = clamp(p, vec2(0.5), vec2(size) - 0.5) - 0.5, centre = floor(at + 0.5), off = at - centre;
    off = mix(off, vec2(0.0), lessThan(abs(off), vec2(ON_A_CENTRE)));
    vec2 t = abs(off), u = 1.0 - t;
    // Texels a, b, c, d from the nearest one: beside it, above it, across the corner. Before it, and beyond b and c.
    ivec2 n = ivec2(centre), side = ivec2(off.x < 0.0 ? -1 : 1, off.y < 0.0 ? -1 : 1), last = size - 1;
    ivec2 beside = clamp(n + side, ivec2(0), last), before = clamp(n - side, ivec2(0), last), beyond = clamp(n + 2 * side, ivec2(0), last);
    vec4 a = colour_texel(n), b = colour_texel(ivec2(beside.x, n.y)), c = colour_texel(ivec2(n.x, beside.y)), d = colour_texel(beside);
    vec4 before_a = colour_texel(ivec2(before.x, n.y)), beyond_b = colour_texel(ivec2(beyond.x, n.y));
    vec4 below_a = colour_texel(ivec2(n.x, before.y)), beyond_c = colour_texel(ivec2(n.x, beyond.y));
    float covered = a.a + b.a + c.a + d.a + before_a.a + beyond_b.a + below_a.a + beyond_c.a;
    vec4 along = beside_the_line(t.x), across = beside_the_line(t.y);
    vec3 sharp = (u.x * u.y + along.y + across.y) * a.rgb + (t.x * u.y + along.z) * b.rgb + (u.x * t.y + across.z) * c.rgb
               + t.x * t.y * d.rgb + along.x * before_a.rgb + along.w * beyond_b.rgb + across.x * below_a.rgb + across.w * beyond_c.rgb;
    vec3 least = min(min(a.rgb, b.rgb), min(c.rgb, d.rgb)), most = max(max(a.rgb, b.rgb), max(c.rgb, d.rgb));
    vec4 linear = mix(mix(a, b, t.x), mix(c, d, t.x), t.y);
    return covered < 8.0 ? linear : vec4(clamp(sharp, least, most), 1.0);
}
