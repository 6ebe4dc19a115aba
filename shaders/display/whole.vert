// One triangle over the whole viewport.
// In: nothing. Out: clip space.
// Source: Bilodeau 2014, Vertex Shader Tricks (GDC): one oversized triangle from gl_VertexID alone.

void main() {
    vec2 ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(ndc, 0.0, 1.0);
}
