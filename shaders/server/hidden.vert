// Rectangles at the near end of the depth range.
// In: their corners. Out: clip space.
// Source: none.
in vec2 in_ndc;

void main() {
    gl_Position = vec4(in_ndc, -1.0, 1.0);
}
