// Put covered pixels in front of everything drawn later, so that a model is drawn into the holes
// only.
// In: the shown picture with holes, and its inverse depth. Out: both unchanged where covered, at
// depth 0; nothing in holes.
// Source: the same trick as a cockpit mask: Vlachos 2015, Advanced VR Rendering (GDC), the hidden
// area mesh.
uniform sampler2D warped;
uniform sampler2D warped_inverse_depth;

layout(location = 0) out vec4 colour;
layout(location = 1) out float inverse_depth;

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    colour = texelFetch(warped, p, 0);
    inverse_depth = texelFetch(warped_inverse_depth, p, 0).r;
    if (colour.a == 0.0) discard;
    gl_FragDepth = 0.0;
}
