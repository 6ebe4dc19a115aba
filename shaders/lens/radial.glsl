// The radial lens: where a panel pixel lies on it, and the magnification of each colour channel
// there. The tangent that the lens shows of a channel is on_lens * its scale. Needs LENS_TERMS, the
// number of terms of the polynomials.
uniform vec4 lens_from_panel;        // scale xy, offset zw: panel pixel -> lens plane, in units of the lens
uniform vec4 shown_from_tangent;     // scale xy, offset zw: tangent -> 0..1 of the shown picture
uniform vec3 lens_terms[LENS_TERMS]; // coefficients of r^0, r^2, .. for red, green and blue
vec3 terms[LENS_TERMS];              // copies made before the loop, see lib/gather.glsl

void prepare_lens() {
    for (int i = 0; i < LENS_TERMS; ++i) terms[i] = lens_terms[i];
}

vec3 lens_scales(vec2 on_lens) {
    float r2 = dot(on_lens, on_lens);
    vec3 scales = terms[LENS_TERMS - 1];
    for (int i = LENS_TERMS - 2; i >= 0; --i) scales = scales * r2 + terms[i];
    return scales;
}
