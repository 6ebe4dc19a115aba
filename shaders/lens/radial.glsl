// The radial lens: where a panel pixel lies on it, and by how much each colour is magnified there.
// The tangent the lens shows of one colour is on_lens * its scale.
uniform vec4 lens_from_panel;    // scale xy, offset zw: panel pixel -> lens plane, in units of the lens
uniform vec4 shown_from_tangent; // scale xy, offset zw: tangent -> 0..1 of the shown picture
uniform float tangent_per_unit;
uniform mat3 red, green, blue;   // up to nine coefficients of r^0, r^2, .. each, column after column

float scale_at(mat3 k, float r2) {
    float s = k[2].z;
    s = s * r2 + k[2].y; s = s * r2 + k[2].x;
    s = s * r2 + k[1].z; s = s * r2 + k[1].y; s = s * r2 + k[1].x;
    s = s * r2 + k[0].z; s = s * r2 + k[0].y; s = s * r2 + k[0].x;
    return s;
}

vec3 lens_scales(vec2 on_lens) {
    float r2 = dot(on_lens, on_lens);
    return vec3(scale_at(red, r2), scale_at(green, r2), scale_at(blue, r2)) * tangent_per_unit;
}
