// The edges of each picture that do not belong to the surface: its gradient less the median of all.
// Edges are rare, so they do not overlap in most pictures, where light does.
// In: the aligned pictures. Out: per layer at half the size, the steps of brightness to the right
// and up that are left, and 1 where all of them are known.
// Source: Weiss 2001, Deriving Intrinsic Images from Image Sequences (the median of gradients).
#include "lib/rows.glsl"
#include "effects/mirrored.glsl"
uniform sampler2DArray aligned;
uniform vec2 rendered_pixel; // 1 / rendered_size
uniform ivec2 half_size;
uniform int pictures;
layout(rgba16f, binding = 2) writeonly uniform image2DArray written;
const vec3 BRIGHTNESS = vec3(0.2126, 0.7152, 0.0722);
const float KNEE = 0.1; // steps beyond it count for little more: lamps are thousands of times as bright as paper

// Brightness of a half pixel, -1 where a pixel of it is not seen.
float brightness(ivec2 at, int layer) {
    vec4 sum = textureLod(aligned, vec3(vec2(2 * at + 1) * rendered_pixel, float(layer)), 0.0);
    return sum.a > 0.99 ? dot(sum.rgb, BRIGHTNESS) : -1.0;
}

// The middle of those that are known; of the middle two the smaller.
float median_of(vec4 values, int count) {
    for (int pass = 0; pass < 3; ++pass) {
        values = values.x > values.y ? values.yxzw : values;
        values = values.y > values.z ? values.xzyw : values;
        values = values.z > values.w ? values.xywz : values;
    }
    float low = values[max(count - 1, 0) / 2], high = values[min(count / 2, 3)];
    return abs(low) <= abs(high) ? low : high;
}

float bent(float x) {
    return x * inversesqrt(1.0 + x * x / (KNEE * KNEE));
}

void visit(ivec2 p) {
    float own = depth_at(2 * p);
    bvec2 joined = bvec2(of_one_surface(own, depth_at(2 * p + ivec2(2, 0))), of_one_surface(own, depth_at(2 * p + ivec2(0, 2))));
    bool within = all(lessThan(2 * p + 3, rendered_size));
    vec4 right = vec4(1e30), up = vec4(1e30);
    bvec4 known = bvec4(false);
    int count = 0;
    for (int k = 0; k < pictures; ++k) {
        float here = brightness(p, k), beside = brightness(p + ivec2(1, 0), k), above = brightness(p + ivec2(0, 1), k);
        known[k] = within && all(joined) && here > -1.0 && beside > -1.0 && above > -1.0;
        right[k] = known[k] ? beside - here : 1e30;
        up[k] = known[k] ? above - here : 1e30;
        count += int(known[k]);
    }
    vec2 surface = vec2(median_of(right, count), median_of(up, count));
    for (int k = 0; k < pictures; ++k) {
        vec2 left = known[k] ? vec2(bent(right[k] - surface.x), bent(up[k] - surface.y)) : vec2(0.0);
        imageStore(written, ivec3(p, k), vec4(left, float(known[k]), 0.0));
    }
}

void main() {
    ivec2 p = first_pixel();
    if (p.x >= half_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= half_size.y) break;
        visit(p);
    }
}
