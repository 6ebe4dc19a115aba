// The median of the covered ones among a pixel's eight neighbours, channel by channel, where there
// are at least `minimum_count`.
// Source: the interpolation step of the 2014 thesis this project starts from.
#include "lib/coverage.glsl"
layout(rgba16f) readonly uniform image2D warped;
uniform int minimum_count;

const vec3 ABSENT = vec3(1e30); // sorts after every colour

// Three texels of one row of the picture; those outside it are empty.
struct Row {
    vec4 left, middle, right;
};

vec4 texel(ivec2 p) {
    vec4 c = imageLoad(warped, p);
    return c.a > HIDDEN ? c : vec4(ABSENT, 0.0);
}

Row row_at(ivec2 p) {
    return Row(texel(p - ivec2(1, 0)), texel(p), texel(p + ivec2(1, 0)));
}

#define ORDER(a, b) { vec3 low = min(a, b); b = max(a, b); a = low; }

// The mean of the two middle ones of the first `count` of eight sorted values, count 3 to 8 (the
// same one if it is odd).
vec3 middle(int count, vec3 b, vec3 c, vec3 d, vec3 e) {
    vec3 low = count >= 7 ? d : count >= 5 ? c : b;
    vec3 high = count >= 8 ? e : count >= 6 ? d : c;
    high = (count & 1) == 1 ? low : high;
    return 0.5 * (low + high);
}

vec4 interpolated(Row below, Row beside, Row above) {
    vec3 a = below.left.rgb, b = below.middle.rgb, c = below.right.rgb, d = beside.left.rgb;
    vec3 e = beside.right.rgb, f = above.left.rgb, g = above.middle.rgb, h = above.right.rgb;
    vec4 four = vec4(below.left.a, below.middle.a, below.right.a, beside.left.a);
    int count = int(dot(four, vec4(1.0)) + beside.right.a + above.left.a + above.middle.a + above.right.a);
    // Batcher's odd-even merge sort of eight: 19 exchanges, no branch.
    ORDER(a, b) ORDER(c, d) ORDER(e, f) ORDER(g, h)
    ORDER(a, c) ORDER(b, d) ORDER(e, g) ORDER(f, h)
    ORDER(b, c) ORDER(f, g)
    ORDER(a, e) ORDER(b, f) ORDER(c, g) ORDER(d, h)
    ORDER(c, e) ORDER(d, f)
    ORDER(b, c) ORDER(d, e) ORDER(f, g)
    return count >= minimum_count ? vec4(middle(count, b, c, d, e), 1.0) : vec4(0.0);
}
