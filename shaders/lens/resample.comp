// Apply the lens: each panel pixel samples, for each colour channel, the tangent that the lens
// shows there.
// In: shown picture, bound in place of the rendered one. Out: panel; black where the lens shows
// more than was rendered.
// Source: that of the lens's library, LENS; its numbers come from hmdwarp/headsets.
#include "lib/rows.glsl"
#include "lib/gather.glsl"
#include LENS
#include "lib/panel.glsl"

void prepare_pixels() {
    prepare_sampling();
}

vec4 seen(vec2 shown) {
    vec4 colour = sampled(shown);
    return in_view(shown) ? colour : vec4(0.0);
}

#ifdef LENS_TANGENTS
vec4 panel_pixel(ivec2 p, mat3x2 from_axis) {
    vec4 g = seen(axis + from_axis[1]);
    return vec4(seen(axis + from_axis[0]).r, g.g, seen(axis + from_axis[2]).b, g.a);
}
#else
vec4 panel_pixel(ivec2 p, vec2 radius, vec3 scales) {
    vec4 g = seen(axis + scales.g * radius);
#ifdef ONE_COLOUR
    return g;
#else
    return vec4(seen(axis + scales.r * radius).r, g.g, seen(axis + scales.b * radius).b, g.a);
#endif
}
#endif
