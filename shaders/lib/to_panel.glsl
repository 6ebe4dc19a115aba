// Runs a gather warp's `gathered` for every pixel of the panel, once per colour, where the lens shows that colour: one resample from
// the late picture to the panel instead of two. Black where the lens shows more than the shown field of view.
// With p = centre + s d (s the lens's scale of the colour, d along the radius) the map is H p = H centre + s H d: one product for three colours.
#include "lib/rows.glsl"
#include LENS
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 panel_size;
uniform ivec2 shown_size;
vec4 gathered(vec2 shown, vec3 base, vec3 parallax);

vec4 seen(vec2 shown, vec3 base, vec3 parallax) {
    vec4 colour = gathered(shown, base, parallax);
    return inside(shown, shown_size) ? colour : vec4(0.0);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= panel_size.x) return;
    vec2 per_tangent = shown_from_tangent.xy * vec2(shown_size);
    vec2 centre = shown_from_tangent.zw * vec2(shown_size);
    for (int row = 0; row < ROWS; ++row) {
        ivec2 p = first + ivec2(0, row);
        if (p.y >= panel_size.y) break;
        vec2 on_lens = (vec2(p) + 0.5) * lens_from_panel.xy + lens_from_panel.zw;
        vec3 scales = lens_scales(on_lens);
        vec2 radius = on_lens * per_tangent;
#ifdef SCANOUT
        float t = 1.0 - (float(p.y) + 0.5) / float(panel_size.y);
        mat3 H_now = H + t * (H_linear + t * H_square);
        vec3 parallax = e + t * (e_linear + t * e_square);
#else
        mat3 H_now = H;
        vec3 parallax = e;
#endif
        vec3 base = H_now * vec3(centre, 1.0);
        vec3 along = H_now[0] * radius.x + H_now[1] * radius.y;
        vec4 r = seen(centre + scales.r * radius, base + scales.r * along, parallax);
        vec4 g = seen(centre + scales.g * radius, base + scales.g * along, parallax);
        vec4 b = seen(centre + scales.b * radius, base + scales.b * along, parallax);
        imageStore(written, p, vec4(r.r, g.g, b.b, g.a));
    }
}
