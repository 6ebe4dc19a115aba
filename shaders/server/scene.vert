// Project the scene's vertices, and pass uv and baked light on; with LAMPS what they light too,
// with RECEIVERS normal and place in the light atlas.
// In: metres relative to the scene's origin. Out: clip space, w = metres along -z; near plane only,
// no far plane.
// Source: Akenine-Moeller et al. 2018, Real-Time Rendering, 4.7.2 (projection with an infinite far
// plane).
uniform mat4 clip_from_scene;

invariant gl_Position;  // colour and depth-only draws use two programs, which must agree to the last bit

in vec3 in_position;
#ifdef COLOUR
in vec2 in_uv;
in vec3 in_light;

centroid out vec2 uv;
centroid out vec3 light;
#endif
#if defined(LAMPS) || defined(RECEIVERS)
uniform mat4 scene_from_here;  // where lamps light what is drawn

in vec3 in_normal;
in vec2 in_light_uv;

centroid out vec3 normal;
centroid out vec2 light_uv;
#endif
#ifdef LAMPS
in vec3 in_albedo;

centroid out vec3 place;
centroid out vec3 albedo;
#endif

#if defined(COLOUR) || defined(RECEIVERS)
// 1 everywhere. Mesa 22.3's llvmpipe takes the perspective of what is interpolated at the centroid
// at the pixel's centre: all of it is off by one factor, which this has too.
centroid out float whole;
#endif

void main() {
#if defined(COLOUR) || defined(RECEIVERS)
    whole = gl_VertexID < 0 ? 0.0 : 1.0; // no constant, which compilers would put in its place
#endif
#ifdef COLOUR
    uv = in_uv;
    light = in_light;
#endif
#if defined(LAMPS) || defined(RECEIVERS)
    normal = mat3(scene_from_here) * in_normal;
    light_uv = in_light_uv;
#endif
#ifdef LAMPS
    place = (scene_from_here * vec4(in_position, 1.0)).xyz;
    albedo = in_albedo;
#endif
    gl_Position = clip_from_scene * vec4(in_position, 1.0);
}
