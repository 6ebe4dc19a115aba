// Erase what the newest picture disproves: it sees clearly farther than the place of a kept pixel,
// or a clearly different colour there.
// In: the kept picture; depths and colours around each place of the newest (memory_bounds.comp).
// Out: holes in the kept picture.
// Source: Mark 1999 (thesis), chapter 3 (a picture that looks through a place overrules one that
// saw something there).
#define ROWS 4
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
layout(rgba16f) uniform image2D kept_colour;
layout(r32f) uniform image2D kept_depth;
layout(rg32f) readonly uniform image2D depths;
layout(rgba16f) readonly uniform image2D lowest;
layout(rgba16f) readonly uniform image2D highest;
uniform ivec2 rendered_size; // of both
uniform float depth_tolerance;
uniform float depth_floor; // 1/m
uniform vec2 colour_margin; // absolute, and a share of the brightest around

void check(ivec2 p, vec3 base) {
    float depth = imageLoad(kept_depth, p).r;
    vec3 q = base + e * depth;
    vec2 at = q.xy / q.z;
    float expected = depth / q.z, limit = depth_tolerance * (expected + depth_floor);
    bool seen = depth >= 0.0 && q.z > 0.0 && inside(at, rendered_size);
    ivec2 cell = ivec2(clamp(at, vec2(0.0), vec2(rendered_size))) / 2;
    vec2 range = imageLoad(depths, cell).rg;
    vec4 colour = imageLoad(kept_colour, p), low = imageLoad(lowest, cell), high = imageLoad(highest, cell);
    vec3 margin = colour_margin.x + colour_margin.y * high.rgb;
    bool same = range.r <= expected + limit && range.g >= expected - limit;
    bool recoloured = any(lessThan(colour.rgb, low.rgb - margin)) || any(greaterThan(colour.rgb, high.rgb + margin));
    if (seen && (range.r < expected - limit || (same && recoloured))) {
        imageStore(kept_colour, p, vec4(0.0));
        imageStore(kept_depth, p, vec4(-1.0));
    }
}

void main() {
    ivec2 first = first_pixel(), size = rendered_size;
    if (first.x >= size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= size.y) break;
        check(first + ivec2(0, row), base + H[1] * float(row));
    }
}
