// The whole parts of a sheet with holes, as a surface like any other; what lets light pass is left to pane.frag.
// In: uv and linear light of the sheet. Out: linear RGBA with coverage 1, inverse depth in 1/m; with COLOUR 0 the latter alone.
// Source: as scene.frag; alpha test, OpenGL 1.5 specification, 4.1.4.
in vec2 uv;
in vec3 light;

uniform sampler2D surface;
uniform float opacity;
#if COLOUR
layout(location = 0) out vec4 colour;
layout(location = 1) out float inverse_depth;
#else
layout(location = 0) out float inverse_depth;
#endif
#include "server/whole.glsl"

void main() {
    vec4 texel = texture(surface, uv);
    if (opacity * texel.a <= WHOLE) discard;
#if COLOUR
    colour = vec4(texel.rgb * light, 1.0);
#endif
    inverse_depth = gl_FragCoord.w;
}
