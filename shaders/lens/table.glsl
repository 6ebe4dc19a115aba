// A lens by a table: where a panel pixel lies on it, and the magnification of each colour channel
// there, linear between rows of equal distance from the axis. Beyond the last angle of a colour the
// magnification leads out of every view. Needs LENS_ROWS, the number of rows.
uniform vec4 lens_from_panel;      // scale xy, offset zw: panel pixel -> lens plane, in units of the lens
uniform vec4 shown_from_tangent;   // scale xy, offset zw: tangent -> 0..1 of the shown picture
uniform vec3 lens_rows[LENS_ROWS]; // scales of red, green and blue
uniform vec3 lens_ends;            // distance of each colour's last angle
uniform float lens_row_step;       // distance between rows
const float NOWHERE = 1e4;

void prepare_lens() {
}

vec3 lens_scales(vec2 on_lens) {
    float r = length(on_lens), row = r / lens_row_step;
    int low = clamp(int(row), 0, LENS_ROWS - 2);
    vec3 scales = mix(lens_rows[low], lens_rows[low + 1], row - float(low));
    return mix(scales, vec3(NOWHERE), greaterThan(vec3(r), lens_ends));
}
