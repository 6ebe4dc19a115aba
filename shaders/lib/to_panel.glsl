// Run a gather warp's `gathered` for every pixel of the panel, once per colour channel, where the
// lens shows that channel: one resample from the rendered picture to the panel instead of two.
// Black where the lens shows more than the shown field of view. A colour samples axis + s radius, s
// its scale, so its map is H axis + s H radius: one product for three colours.
#include "lib/rows.glsl"
#include "lib/gather.glsl"
#include LENS
#include "lib/panel.glsl"
vec4 gathered(vec2 shown, vec3 base, vec3 parallax);

mat3 map, now; // `now` is that of the row
vec3 map_e;
#ifdef SCANOUT
mat3 map_linear, map_square;
vec3 e_by_t, e_by_t2;
float row_share;
#endif

void prepare_pixels() {
    prepare_sampling();
#ifdef PREPARE
    PREPARE();
#endif
    map = H;
    now = H;
    map_e = e;
#ifdef SCANOUT
    map_linear = H_linear;
    map_square = H_square;
    e_by_t = e_linear;
    e_by_t2 = e_square;
    row_share = 1.0 / float(panel_size.y);
#endif
}

vec3 base_at_centre(vec2 shown, vec3 base) {
    vec2 step = floor(shown) + 0.5 - shown;
    return base + now[0] * step.x + now[1] * step.y;
}

// The parallax of a row; sets `now` to its map.
vec3 parallax_of_row(ivec2 p) {
#ifdef SCANOUT
    float t = 1.0 - (float(p.y) + 0.5) * row_share;
    now = map + t * (map_linear + t * map_square);
    return map_e + t * (e_by_t + t * e_by_t2);
#else
    return map_e;
#endif
}

#ifdef LENS_TANGENTS
vec4 channel(vec2 from_axis, vec3 parallax) {
    vec2 shown = axis + from_axis;
    return in_view(shown) ? gathered(shown, now * vec3(shown, 1.0), parallax) : vec4(0.0);
}

vec4 panel_pixel(ivec2 p, mat3x2 from_axis) {
    vec3 parallax = parallax_of_row(p);
    vec4 g = channel(from_axis[1], parallax);
    return vec4(channel(from_axis[0], parallax).r, g.g, channel(from_axis[2], parallax).b, g.a);
}
#else
vec4 panel_pixel(ivec2 p, vec2 radius, vec3 scales) {
    vec3 parallax = parallax_of_row(p);
    vec3 on_axis = now * vec3(axis, 1.0), along = now[0] * radius.x + now[1] * radius.y;
    vec2 green = axis + scales.g * radius;
    vec4 g = gathered(green, on_axis + scales.g * along, parallax);
    bool sees = in_view(green);
#ifdef ONE_COLOUR
    return sees ? g : vec4(0.0);
#else
    vec2 red = axis + scales.r * radius, blue = axis + scales.b * radius;
    float r = gathered(red, on_axis + scales.r * along, parallax).r;
    float b = gathered(blue, on_axis + scales.b * along, parallax).b;
    return vec4(in_view(red) ? r : 0.0, sees ? g.g : 0.0, in_view(blue) ? b : 0.0, sees ? g.a : 0.0);
#endif
}
#endif
