// Rectangles at the end of the depth range that is nearest, NEAREST in clip space.
// In: their corners. Out: clip space.
// Source: none.
in vec2 in_ndc;

void main() {
    gl_Position = vec4(in_ndc, NEAREST, 1.0);
}
