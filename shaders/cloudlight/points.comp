// Projects points as discs; the nearest disc of each pixel wins.
// In: points. Out: the nearest key of each pixel (turn 0), then the lowest point that has it (turn
// 1).
// Source: Zwicker et al. 2001, Surface Splatting; keys as lib/depth_key.glsl; Hoff et al. 1999 (a
// depth that rises from the middle gives each pixel to the nearest middle).
layout(local_size_x = 64) in;
#include "lib/point_discs.glsl"
#include "lib/depth_key.glsl"
uniform int count;
// One program for both turns: two programs may round a key differently, and its point is not found.
uniform int turn;
uniform float largest;
// A point that covers no middle of a pixel is drawn in its own pixel, but behind all that do: else
// what is near grows by half a pixel, the more the denser its points are.
const float BEHIND = 1.0 / 1024.0;
// How much farther a disc's edge counts than its middle, in radii.
const float RISE = 0.5;

void offer(ivec2 at, uint index, float inverse_depth) {
    uint slot = uint(at.y) * uint(shown_size.x) + uint(at.x);
    uint key = depth_key(inverse_depth, ivec2(index, index >> 2), index);
    if (turn == 0) atomicMax(key_of[slot], key);
    else if (key_of[slot] == key) atomicMin(winner_of[slot], index);
}

void main() {
    uint index = gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * 64u) + gl_GlobalInvocationID.x;
    if (index >= uint(count)) return;
    Disc disc = disc_of(index);
    if (!disc.drawn) return;
    float depth = -disc.middle.z;
    vec2 centre = (disc.middle.xy / depth - lowest) * pixels;
    vec2 reach = min(disc.radius / depth * pixels * (1.0 + length(disc.middle.xy) / depth), vec2(largest));
    if (any(lessThan(centre + reach, vec2(0.0))) || any(greaterThan(centre - reach, vec2(shown_size)))) return;
    ivec2 own = ivec2(floor(centre));
    ivec2 first = max(ivec2(floor(centre - reach)), ivec2(0));
    ivec2 last = min(ivec2(floor(centre + reach)), shown_size - 1);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec2 found = met(disc, vec2(x, y) + 0.5);
            if (found.y <= 1.0)
                offer(ivec2(x, y), index, found.x * (1.0 - min(RISE * found.y * disc.radius * found.x, 0.5)));
            else if (ivec2(x, y) == own)
                offer(own, index, BEHIND / (depth + RISE * disc.radius));
        }
}
