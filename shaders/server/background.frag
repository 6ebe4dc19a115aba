// The background, infinitely far: a sky that fades from zenith to horizon, and ground below it.
// In: direction in world axes, any length. Out: linear RGBA with coverage 1; inverse depth 0. With
// PEEL nothing (0, 0, 0, 0; -1) where the previous layer already has it.
// Source: this project's; the square root keeps the glow of a horizon low above it. Everitt 2001
// (peeling).
#ifdef PEEL
#include "lib/peel.glsl"
#endif
#ifdef COLOUR
uniform vec3 zenith;
uniform vec3 horizon;
uniform vec3 ground;

in vec3 direction;

layout(location = 0) out vec4 colour;
layout(location = 1) out float inverse_depth;
#else
layout(location = 0) out float inverse_depth;
#endif

void main() {
#ifdef COLOUR
    float up = normalize(direction).y;
    colour = vec4(mix(horizon, up > 0.0 ? zenith : ground, sqrt(abs(up))), 1.0);
#endif
    inverse_depth = 0.0;
#ifdef PEEL
    if (!behind(0.0)) {
        colour = vec4(0.0);
        inverse_depth = -1.0;
    }
#endif
}
