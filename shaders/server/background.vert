// One triangle over the whole picture at the far end of the depth range; gives each pixel its
// direction in the world.
// In: nothing. Out: clip space; `direction` in world axes, of length 1 along -z of the eye (linear
// across the picture).
// Source: Bilodeau 2014, Vertex Shader Tricks (GDC): one oversized triangle from gl_VertexID alone.
uniform mat3 world_from_ndc;

out vec3 direction;

void main() {
    vec2 ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    direction = world_from_ndc * vec3(ndc, 1.0);
    gl_Position = vec4(ndc, 1.0, 1.0);
}
