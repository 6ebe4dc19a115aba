// Project what deforms, as scene.vert does; with LATE also where each place was in the late picture.
// In: metres relative to the scene's origin, then and now. Out: clip space; metres along the axes of
// the late picture's eye.
// Source: as scene.vert.
uniform mat4 clip_from_scene;

invariant gl_Position; // must match scene.vert to the last bit

in vec3 in_position;
in vec2 in_uv;
in vec3 in_light;

out vec2 uv;
out vec3 light;
#if LATE
uniform mat4 late_from_scene;
in vec3 in_late;
in vec3 in_baked;

out vec3 place;
out vec3 baked;
#endif

void main() {
    uv = in_uv;
    light = in_light;
#if LATE
    place = (late_from_scene * vec4(in_late, 1.0)).xyz;
    baked = in_baked;
#endif
    gl_Position = clip_from_scene * vec4(in_position, 1.0);
}
