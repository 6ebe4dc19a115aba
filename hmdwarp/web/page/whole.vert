// One triangle over the whole picture; SEEN: those of a view that can be seen, past what a lens hides.
// In: for SEEN, tangents. Out: their place in the view.
// Source: WebXR Device API, XRVisibilityMaskChangeEvent.
#ifdef SEEN
layout(location = 0) in vec2 place;
uniform vec4 edges; // tangents of the view: left, right, down, up
#endif

void main() {
#ifdef SEEN
    gl_Position = vec4(2.0 * (place - edges.xz) / (edges.yw - edges.xz) - 1.0, 0.0, 1.0);
#else
    gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
#endif
}
