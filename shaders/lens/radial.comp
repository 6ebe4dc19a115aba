// Applies the lens: each panel pixel looks up, for each colour of its own, the tangent the lens shows there.
// In: shown picture. Out: panel; black where the lens shows more than was rendered.
// Source: radial polynomial in r^2 (Brown 1966), one per colour; the coefficients come from hmdwarp/headsets.
#define ROWS 4 // eight would spill registers
#include "lib/rows.glsl"
uniform sampler2D shown;
layout(rgba16f) writeonly uniform image2D panel;
uniform ivec2 panel_size;
uniform vec4 lens_from_panel;   // scale xy, offset zw: panel pixel -> lens plane, in units of the lens
uniform vec4 shown_from_tangent; // scale xy, offset zw: tangent -> 0..1 of the shown picture
uniform float tangent_per_unit;
uniform mat3 red, green, blue;  // up to nine coefficients of r^0, r^2, .. each, column after column

float scale_at(mat3 k, float r2) {
    float s = k[2].z;
    s = s * r2 + k[2].y; s = s * r2 + k[2].x;
    s = s * r2 + k[1].z; s = s * r2 + k[1].y; s = s * r2 + k[1].x;
    s = s * r2 + k[0].z; s = s * r2 + k[0].y; s = s * r2 + k[0].x;
    return s;
}

vec4 seen(vec2 on_lens, float r2, mat3 coefficients) {
    vec2 tangent = on_lens * (scale_at(coefficients, r2) * tangent_per_unit);
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
        float r2 = dot(on_lens, on_lens);
        vec4 g = seen(on_lens, r2, green);
        imageStore(panel, p, vec4(seen(on_lens, r2, red).r, g.g, seen(on_lens, r2, blue).b, g.a));
    }
}
