// Lay one panel over the display's picture, in place, through the lens: its only sample, each colour where
// the lens shows it.
// In: pixel of the display; its picture, of a warp that looks through the lens. Out: the same.
// Source: Porter and Duff 1984, Compositing Digital Images (over); lib/panel_sample.glsl.
#include "lib/rows.glsl"
#include "lib/coverage.glsl"
#include "lib/panel_sample.glsl"
layout(rgba16f) readonly uniform image2D picture; // that which is written, too
// To q of a shown pixel at the time t of a row: at_first + t (linear + t square), as in to_panel.glsl.
uniform mat3 at_first, linear, square;
#include LENS
#include "lib/panel.glsl"

const float WHOLE = 1.0 - 1.0 / 512.0; // the least value that half floats may leave of 1

void prepare_pixels() {}

// The shown pixels that the lens shows there in red, green and blue.
mat3x2 shown_at(vec2 on_lens) {
#ifdef LENS_TANGENTS
    mat3x2 from_axis = from_axis_at(on_lens);
    return mat3x2(axis + from_axis[0], axis + from_axis[1], axis + from_axis[2]);
#else
    vec3 scales = lens_scales(on_lens);
    vec2 radius = on_lens * per_tangent;
    return mat3x2(axis + scales.r * radius, axis + scales.g * radius, axis + scales.b * radius);
#endif
}

vec4 laid_over(ivec2 p) {
    vec4 behind = imageLoad(picture, p);
    if (behind.a > 0.0 && behind.a <= HIDDEN) return behind;
    float t = 1.0 - (float(p.y) + 0.5) / float(panel_size.y);
    mat3 map = at_first + t * (linear + t * square);
    vec2 on_lens = on_lens_at(p.x, p.y), across = vec2(0.5 * lens_placing.x, 0.0), along = vec2(0.0, 0.5 * lens_placing.y);
    mat3x2 here = shown_at(on_lens);
    mat3x2 right = shown_at(on_lens + across) - shown_at(on_lens - across);
    mat3x2 up = shown_at(on_lens + along) - shown_at(on_lens - along);
    vec4 over = vec4(0.0);
    vec3 covers = vec3(0.0);
    for (int colour = 0; colour < 3; ++colour) {
        if (!in_view(here[colour])) continue;
        vec3 q = map * vec3(here[colour], 1.0);
        vec4 found = panel_colour(q, map * vec3(right[colour], 0.0), map * vec3(up[colour], 0.0));
        over[colour] = found[colour];
        covers[colour] = found.a;
    }
    if (max(behind.a, covers.g) < WHOLE) return behind;
    return vec4(over.rgb + max(1.0 - covers, 0.0) * behind.rgb, 1.0);
}

#ifdef LENS_TANGENTS
vec4 panel_pixel(ivec2 p, mat3x2 from_axis) {
    return laid_over(p);
}
#else
vec4 panel_pixel(ivec2 p, vec2 radius, vec3 scales) {
    return laid_over(p);
}
#endif
