// Applies the lens: each panel pixel looks up, for each colour of its own, the tangent the lens shows there.
// In: shown picture. Out: panel; black where the lens shows more than was rendered.
// Source: radial polynomial in r^2 (Brown 1966), one per colour; the coefficients come from hmdwarp/headsets.
#define ROWS 4 // eight would spill registers
#include "lib/rows.glsl"
#include "lens/radial.glsl"
uniform sampler2D shown;
layout(rgba16f) writeonly uniform image2D panel;
uniform ivec2 panel_size;

vec4 seen(vec2 tangent) {
    vec2 uv = tangent * shown_from_tangent.xy + shown_from_tangent.zw;
    vec4 colour = textureLod(shown, uv, 0.0);
    return uv.x >= 0.0 && uv.y >= 0.0 && uv.x <= 1.0 && uv.y <= 1.0 ? colour : vec4(0.0);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= panel_size.x) return;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 p = first + ivec2(0, row);
        if (p.y >= panel_size.y) break;
        vec2 on_lens = (vec2(p) + 0.5) * lens_from_panel.xy + lens_from_panel.zw;
        vec3 scales = lens_scales(on_lens);
        vec4 g = seen(on_lens * scales.g);
        imageStore(panel, p, vec4(seen(on_lens * scales.r).r, g.g, seen(on_lens * scales.b).b, g.a));
    }
}
