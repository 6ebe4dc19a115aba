// The depth of a cut-out sheet, such as a fence: texels that pass less than half of the light have
// the sheet's depth, the others are discarded.
// In: uv of the sheet. Out: inverse depth in 1/m.
// Source: alpha test, OpenGL 1.5 specification, 4.1.4.
in vec2 uv;

uniform sampler2D surface;
uniform float opacity;

layout(location = 0) out float inverse_depth;

void main() {
    if (opacity * texture(surface, uv).a < 0.5) discard;
    inverse_depth = gl_FragCoord.w;
}
