// The lens of SteamVR's configuration: where a panel pixel lies, in half widths of the panel from its
// middle, and the tangent that each colour channel shows there. Beyond the cutoff it leads out of
// every view.
uniform vec4 lens_from_panel;    // scale xy, offset zw: panel pixel -> half widths from the middle
uniform vec4 shown_from_tangent; // scale xy, offset zw: tangent -> 0..1 of the shown picture
uniform vec4 lens_terms[3];      // k1, k2, k3, k4 of red, green and blue
uniform vec2 lens_centres[3];    // of red, green and blue
uniform float lens_focal;        // in half widths
uniform float lens_cutoff;       // of r^2
const float NOWHERE = 1e4;

void prepare_lens() {
}

vec2 tangent_of(int colour, vec2 on_lens) {
    vec2 place = on_lens - lens_centres[colour];
    vec4 k = lens_terms[colour];
    float r2 = dot(place, place);
    float scale = 1.0 / (1.0 + r2 * (k.x + r2 * (k.y + r2 * k.z))) + k.w;
    return r2 > lens_cutoff ? vec2(NOWHERE) : place * (scale / lens_focal);
}

mat3x2 lens_tangents(vec2 on_lens) {
    return mat3x2(tangent_of(0, on_lens), tangent_of(1, on_lens), tangent_of(2, on_lens));
}
