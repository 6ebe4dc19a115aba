// The colour of a mesh drawn by mesh.vert.
// In: where it was rendered. Out: colour and coverage; inverse depth.
// Source: as mesh.vert.
uniform sampler2D rendered_colour;
in vec2 place;
in float found_inverse_depth;
layout(location = 0) out vec4 written;
layout(location = 1) out vec4 shown_inverse_depth;

void main() {
    vec4 sum = textureLod(rendered_colour, place, 0.0);
    written = sum.a >= 0.5 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
    shown_inverse_depth = vec4(written.a > 0.0 ? found_inverse_depth : -1.0);
}
