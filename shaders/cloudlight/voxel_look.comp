// Indirect light of each pixel of a picture, gathered from a grid along cones.
// In: places and normals, metres from the scene's origin. Out: linear RGB, 0 where lamps light
// nothing.
// Source: as lib/voxels.glsl.
#include "lib/voxels.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D near_place_of;
uniform sampler2D near_normal_of;
layout(rgba16f) writeonly uniform image2D near_light;
uniform ivec2 near_size;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= near_size.x || p.y >= near_size.y) return;
    vec4 place = texelFetch(near_place_of, p, 0);
    vec3 light = vec3(0.0);
    if (place.w > 0.0) light = voxel_light(place.xyz, texelFetch(near_normal_of, p, 0).xyz);
    imageStore(near_light, p, vec4(light, 1.0));
}
