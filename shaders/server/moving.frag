// A pixel's motion, where the picture shows a moving thing: the number of its body, or (VELOCITY)
// its velocity.
// In: m/s along the eye's axes; the picture's inverse depth. Out: number of the body; or m/s with
// coverage 1.
// Source: a G-buffer's object ids and velocities (Saito and Takahashi 1990); the picture's own
// depth decides what is visible, whatever drew it.
#if VELOCITY
in vec3 velocity;
layout(location = 0) out vec4 moves;
#else
uniform uint body;
layout(location = 0) out uint moves;
#endif
uniform sampler2D picture; // its inverse depth
uniform float same;        // relative difference of inverse depth between two programs that draw the same surface

void main() {
    float shown = texelFetch(picture, ivec2(gl_FragCoord.xy), 0).r;
    if (abs(shown - gl_FragCoord.w) > same * gl_FragCoord.w) discard;
#if VELOCITY
    moves = vec4(velocity, 1.0);
#else
    moves = body;
#endif
}
