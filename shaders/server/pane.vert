// Project the transparent sheets, or the overlay, exactly as scene.vert does, and pass uv and light
// on.
// In: metres relative to the scene's origin, to a body or to the head. Out: clip space, w = metres
// along -z; uv; linear light.
// Source: as scene.vert.
uniform mat4 clip_from_scene;

invariant gl_Position; // the draws of one layer use two programs, which must agree to the last bit

in vec3 in_position;
in vec2 in_uv;
in vec3 in_light;

out vec2 uv;
out vec3 light;

void main() {
    uv = in_uv;
    light = in_light;
    gl_Position = clip_from_scene * vec4(in_position, 1.0);
}
