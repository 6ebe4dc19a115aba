// As scene.vert, for the world behind a mirror; everything behind the mirror itself is clipped.
// In: metres relative to the scene's origin. Out: clip space, w = metres along -z; clip distance in
// metres in front of the mirror.
// Source: Akenine-Moeller et al. 2018, Real-Time Rendering, 11.6.2 (planar reflections).
uniform mat4 clip_from_scene;
uniform vec4 before_mirror; // plane: distance in front of the mirror of a point in the scene

in vec3 in_position;
in vec2 in_uv;
in vec3 in_light;

out vec2 uv;
out vec3 light;
out float whole; // as of scene.vert
out float gl_ClipDistance[1];

// Things that touch the mirror lose this much of their image, and the mirror has none in itself.
const float SKIN_M = 1e-3;

void main() {
    uv = in_uv;
    light = in_light;
    whole = 1.0;
    gl_Position = clip_from_scene * vec4(in_position, 1.0);
    gl_ClipDistance[0] = dot(before_mirror, vec4(in_position, 1.0)) - SKIN_M;
}
