// What the lens hides of a view, drawn first and nearest of all, so that the depth test leaves
// everything else out: nothing is there.
// In: nothing. Out: RGBA 0, inverse depth -1.
// Source: Vlachos 2015, Advanced VR Rendering (GDC): the hidden area mesh.
#ifdef COLOUR
layout(location = 0) out vec4 colour;
layout(location = 1) out float inverse_depth;
#else
layout(location = 0) out float inverse_depth;
#endif

void main() {
#ifdef COLOUR
    colour = vec4(0.0);
#endif
    inverse_depth = -1.0;
}
