// Erase what the newest picture disproves: it sees clearly farther than the place of a kept pixel,
// or a clearly different colour there. One pixel of each block is compared, in 4 x 4 pixels around
// its place, and stands for all of the block; each run compares another one.
// In: the kept picture; the newest one. Out: holes in the kept picture and in its seeds.
// Source: Mark 1999 (thesis), chapter 3 (a picture that looks through a place overrules one that
// saw something there).
#define ROWS 2
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
layout(rgba16f) uniform image2D kept_colour;
layout(r32f) uniform image2D kept_depth;
layout(r32f) writeonly uniform image2D seeds; // memory_seeds.comp
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(r32f) readonly uniform image2D rendered_depth;
uniform ivec2 rendered_size; // of both
uniform ivec2 place; // in its block, of the pixel that is compared
uniform int block; // pixels along its side, even
uniform int once; // 1: a loop that no neighbour enters is skipped, an `if` is not
uniform float depth_tolerance;
uniform float depth_floor; // 1/m
uniform vec2 colour_margin; // absolute, and a share of the brightest around

const float UNKNOWN = 1e30;

bool is_disproved(ivec2 p, vec3 base) {
    float depth = imageLoad(kept_depth, p).r;
    vec3 q = base + e * depth, colour = imageLoad(kept_colour, p).rgb;
    vec2 at = q.xy / q.z;
    bool is_pixel = all(lessThan(p, rendered_size)); // of a block that ends beyond the border
    bool seen = is_pixel && depth >= 0.0 && q.z > 0.0 && inside(at, rendered_size);
    // The even pixel before and the odd one after, and one around: nearest is infinite where any of
    // them is unknown, so that they disprove nothing.
    ivec2 from = 2 * (ivec2(clamp(at, vec2(0.0), vec2(rendered_size))) / 2) - 1;
    float nearest = -1.0, farthest = UNKNOWN;
    vec3 low = vec3(UNKNOWN), high = vec3(-UNKNOWN);
    for (int i = seen ? 0 : 16 * once; i < 16 * once; ++i) {
        ivec2 around = clamp(from + ivec2(i & 3, i >> 2), ivec2(0), rendered_size - 1);
        float there = imageLoad(rendered_depth, around).r;
        vec3 shows = imageLoad(rendered_colour, around).rgb;
        nearest = max(nearest, there >= 0.0 ? there : UNKNOWN); // NaN counts as unknown
        farthest = min(farthest, there);
        low = min(low, shows);
        high = max(high, shows);
    }
    float expected = depth / q.z, limit = depth_tolerance * (expected + depth_floor);
    vec3 margin = colour_margin.x + colour_margin.y * high;
    bool same = nearest <= expected + limit && farthest >= expected - limit;
    bool recoloured = any(lessThan(colour, low - margin)) || any(greaterThan(colour, high + margin));
    return seen && (nearest < expected - limit || (same && recoloured));
}

void erase(ivec2 first) {
    for (int i = 0; i < block * block; ++i) {
        ivec2 p = first + ivec2(i % block, i / block);
        imageStore(kept_colour, p, vec4(0.0));
        imageStore(kept_depth, p, vec4(-1.0));
        imageStore(seeds, p / 2, vec4(-1.0));
    }
}

void main() {
    ivec2 first = block * first_pixel(), size = rendered_size;
    if (first.x >= size.x) return;
    for (int row = 0; row < ROWS; ++row, first.y += block) {
        if (first.y >= size.y) break;
        ivec2 p = first + place;
        bool gone = is_disproved(p, H * vec3(vec2(p) + 0.5, 1.0));
        for (int turn = gone ? 0 : once; turn < once; ++turn) erase(first);
    }
}
