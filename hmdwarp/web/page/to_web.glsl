// Run a gather warp's `gathered` for a pixel of the shown view, as a fragment shader of WebGL 2.
// The rows of the rendered picture come top first: its part of H and e is turned over.
#include "lib/gather.glsl"
uniform ivec2 shown_size;
layout(location = 0) out vec4 written;
layout(location = 1) out vec4 shown_inverse_depth; // of `gathered`, -1 in holes
float found_inverse_depth;
vec4 gathered(vec2 shown, vec3 base, vec3 parallax);

void main() {
    prepare_sampling();
    vec2 shown = gl_FragCoord.xy;
    written = gathered(shown, H * vec3(shown, 1.0), e);
    shown_inverse_depth = vec4(written.a > 0.0 ? found_inverse_depth : -1.0);
}
