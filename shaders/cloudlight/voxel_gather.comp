// One more bounce of light: what each surface in the cells of a grid gets from the grid.
// In: as voxel_direct.comp. Out: linear RGB that each sends.
// Source: as lib/voxels.glsl.
#include "lib/voxel_pieces.glsl"
#include "lib/voxels.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= piece_count) return;
    vec3 got = direct_of[i].rgb + voxel_light(piece_of[i].place.xyz, piece_of[i].normal.xyz);
    sent_by[i] = vec4(piece_of[i].albedo.rgb * got, 0.0);
}
