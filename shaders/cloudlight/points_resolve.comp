// Colours the pixels that points have won. An empty pixel beside a disc is a crack, and a hole;
// farther away it is sky.
// In: the winner of each pixel, points. Out: colour and inverse depth; 0 and -1 in holes.
// Source: this project's; the sky as in server/background.frag.
#include "lib/rows.glsl"
#include "lib/srgb.glsl"
#include "lib/point_discs.glsl"
layout(rgba16f) writeonly uniform image2D shown_colour;
#if WRITES_DEPTH
layout(r32f) writeonly uniform image2D shown_inverse_depth;
#endif
uniform vec3 zenith;
uniform vec3 horizon;
uniform vec3 ground;
uniform vec3 up; // the world's up in eye space
uniform int has_sky;
const int RIM = 2; // pixels

vec3 colour_of(uint word) {
    return light_of(vec3(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u) / 255.0);
}

bool beside(ivec2 at) {
    ivec2 low = max(at - RIM, ivec2(0)), high = min(at + RIM, shown_size - 1);
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x)
            if (winner_of[uint(y) * uint(shown_size.x) + uint(x)] != NOBODY) return true;
    return false;
}

void resolve(ivec2 at) {
    uint slot = uint(at.y) * uint(shown_size.x) + uint(at.x);
    uint winner = winner_of[slot];
    vec4 colour = vec4(0.0);
    float inverse_depth = -1.0;
    if (winner != NOBODY) {
        Disc disc = disc_of(winner);
        vec2 found = met(disc, vec2(at) + 0.5);
        colour = vec4(colour_of(point_of[3u * winner + 2u]), 1.0);
        inverse_depth = found.y <= 1.0 ? found.x : -1.0 / disc.middle.z;
    } else if (has_sky != 0 && !beside(at)) {
        float high = dot(normalize(vec3(lowest + (vec2(at) + 0.5) / pixels, -1.0)), up);
        colour = vec4(mix(horizon, high > 0.0 ? zenith : ground, sqrt(abs(high))), 1.0);
        inverse_depth = 0.0;
    }
    imageStore(shown_colour, at, colour);
#if WRITES_DEPTH
    imageStore(shown_inverse_depth, at, vec4(inverse_depth));
#endif
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    for (int row = 0; row < ROWS; ++row)
        if (first.y + row < shown_size.y) resolve(first + ivec2(0, row));
}
