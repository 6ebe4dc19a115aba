// Linear colour (texture times baked light; with LAMPS, times the light of the scene's lamps) with
// coverage 1, and inverse depth; with PEEL only of what lies behind the previous layer. With
// SPLATTED or VOXELS indirect light is from a picture or a grid and not from the light atlas. With
// RECEIVERS the normal and the light atlas in place of colour.
// EMISSION adds what the surface emits.
// In: uv of the surface, linear light. Out: linear RGBA; inverse depth in 1/m along -z.
// Source: GLSL 4.30 specification, 7.1: gl_FragCoord.w is 1 / w_clip, so it is the inverse depth
// itself, linear across a triangle; Everitt 2001, Interactive Order-Independent Transparency
// (peeling).
#ifdef EMISSION
#include "lib/emission.glsl"
#endif
#ifdef PEEL
#include "lib/peel.glsl"
#endif
#ifdef LAMPS
#include "lib/lamps.glsl"
#ifdef SPLATTED
#include "lib/splatted.glsl"
#elif defined(VOXELS)
#include "lib/voxel_near.glsl"
#endif

centroid in vec3 place;
centroid in vec3 normal;
centroid in vec2 light_uv;
centroid in vec3 albedo;
#endif
#if defined(RECEIVERS) || (defined(LAMPS) && !defined(SPLATTED) && !defined(VOXELS))
#include "lib/light_atlas.glsl"
#endif
#ifdef RECEIVERS
centroid in vec3 normal;
centroid in vec2 light_uv;

layout(location = 0) out vec4 receiver;
layout(location = 1) out float inverse_depth;
#elif defined(COLOUR)
uniform sampler2D surface;

centroid in vec2 uv;
centroid in vec3 light;

layout(location = 0) out vec4 colour;
layout(location = 1) out float inverse_depth;
#else
layout(location = 0) out float inverse_depth;
#endif

#if defined(COLOUR) || defined(RECEIVERS)
centroid in float whole; // divides what is interpolated at the centroid, see scene.vert
#endif

void main() {
#ifdef COLOUR
    // Before a discard: after it the neighbours' uv, and so the mip level, would be undefined
    vec3 texel = texture(surface, uv / whole).rgb;
#ifdef EMISSION
    vec3 shining = emitted(uv / whole);
#else
    const vec3 shining = vec3(0.0);
#endif
#endif
#ifdef PEEL
    if (!behind(gl_FragCoord.w)) discard;
#endif
#ifdef COLOUR
#ifdef LAMPS
    vec3 shown = light / whole;
    if (light_uv.x >= 0.0) {
        vec3 facing_way = normalize(normal), at = place / whole;
#ifdef SPLATTED
        vec3 indirect_light = splatted_light(at, facing_way);
#elif defined(VOXELS)
        vec3 indirect_light = near_light(at, facing_way);
#else
        vec3 indirect_light = of_atlas(light_uv / whole);
#endif
        shown = albedo / whole * (direct_light(at, facing_way) + indirect_light);
    }
    colour = vec4(texel * shown + shining, 1.0);
#else
    colour = vec4(texel * light / whole + shining, 1.0);
#endif
#endif
#ifdef RECEIVERS
    receiver = light_uv.x >= 0.0 ? vec4(normalize(normal), of_atlas(light_uv / whole).r) : vec4(0.0);
#endif
    inverse_depth = gl_FragCoord.w;
}
