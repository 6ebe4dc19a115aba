// A mirror's own surface: positions in the eye's axes and, for a curved one, normals.
// In: metres relative to the scene's origin, uv, normals. Out: clip space; the place and the normal
// in the axes of the eye.
// Source: Akenine-Moeller et al. 2018, Real-Time Rendering, 4.7.2 (projection with an infinite far
// plane).
uniform mat4 clip_from_scene;

invariant gl_Position; // the picture's own surface must have the same depth

in vec3 in_position;
#ifdef CURVED
uniform mat4 eye_from_scene;
in vec3 in_normal;
out vec3 place;
out vec3 normal;
#else
in vec2 in_uv;
out vec2 uv;
#endif

void main() {
#ifdef CURVED
    place = (eye_from_scene * vec4(in_position, 1.0)).xyz;
    normal = mat3(eye_from_scene) * in_normal;
#else
    uv = in_uv;
#endif
    gl_Position = clip_from_scene * vec4(in_position, 1.0);
}
