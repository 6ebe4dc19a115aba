// The triangles of a view that can be seen, past what a headset's lens hides.
// In: tangents. Out: their place in the view.
// Source: WebXR Device API, XRVisibilityMaskChangeEvent.
layout(location = 0) in vec2 place;
uniform vec4 edges; // tangents of the view: left, right, down, up

void main() {
    gl_Position = vec4(2.0 * (place - edges.xz) / (edges.yw - edges.xz) - 1.0, 0.0, 1.0);
}
