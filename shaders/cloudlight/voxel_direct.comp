// Direct light of the surfaces in the cells of a grid, with shadows.
// In: places and normals in metres from the scene's origin. Out: linear RGB of each, what lamps give
// and what is sent of it.
// Source: as lib/lamps.glsl.
#include "lib/voxel_pieces.glsl"
#include "lib/lamps.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= piece_count) return;
    vec3 direct = direct_light(piece_of[i].place.xyz, piece_of[i].normal.xyz);
    direct_of[i] = vec4(direct, 0.0);
    sent_by[i] = vec4(piece_of[i].albedo.rgb * direct, 0.0);
}
