// Project moving things, exactly as scene.vert does, for the motion layers.
// In: metres relative to a body or to the scene's origin; with VELOCITY m/s in world axes. Out:
// clip space; m/s along the eye's axes.
// Source: as scene.vert.
uniform mat4 clip_from_scene;

invariant gl_Position; // must match scene.vert to the last bit

in vec3 in_position;
#if VELOCITY
uniform mat3 eye_from_world;
in vec3 in_velocity;

out vec3 velocity;
#endif

void main() {
#if VELOCITY
    velocity = eye_from_world * in_velocity;
#endif
    gl_Position = clip_from_scene * vec4(in_position, 1.0);
}
