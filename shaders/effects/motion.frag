// The colour of a moved surface: interpolated bilinearly among rendered pixels of the same surface
// only, so that nothing else bleeds into its edge.
// In: rendered pixel and inverse depth, interpolated; the pixel the square belongs to. Out: linear
// colour with coverage 1; inverse depth, 1/m.
// Source: as motion.vert.
#include "effects/motion.glsl"
uniform sampler2D rendered_colour;
in vec3 surface_point;
flat in ivec3 owner;
layout(location = 0) out vec4 colour;
layout(location = 1) out float inverse_depth;

void main() {
    float r = surface_point.z * gl_FragCoord.w;
    Seen own = Seen(owner.xy, uint(owner.z), known_inverse_depth(owner.xy));
    ivec2 here = ivec2(gl_FragCoord.xy);
    bool hidden = moves_with(here) == 0u && known_inverse_depth(here) > r;
    vec2 away = clamp(surface_point.xy - vec2(owner.xy) - 0.5, -0.5, 0.5);
    ivec2 side = ivec2(away.x < 0.0 ? -1 : 1, away.y < 0.0 ? -1 : 1);
    vec2 share = abs(away);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 step = ivec2(k & 1, k >> 1), pixel = owner.xy + step * side;
        bool same = k == 0 || joined(own, seen(pixel));
        vec2 weights = mix(1.0 - share, share, vec2(step));
        if (same) sum += weights.x * weights.y * texelFetch(rendered_colour, clamp(pixel, ivec2(0), rendered_size - 1), 0);
    }
    if (hidden || sum.a <= 0.0) discard;
    colour = vec4(sum.rgb / sum.a, 1.0);
    inverse_depth = r;
}
