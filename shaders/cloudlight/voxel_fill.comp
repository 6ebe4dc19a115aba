// Enter the surfaces of each cell into the finest level of the grid.
// In: surfaces and the light they send, cell by cell. Out: for each way along an axis, the area
// that faces against it in faces of a cell, and light times area.
// Source: Crassin et al. 2011, Interactive Indirect Illumination Using Voxel Cone Tracing.
#include "lib/voxel_pieces.glsl"
layout(std430, binding = 3) readonly buffer Cells { uvec4 cell_of[]; }; // number, first piece, pieces
layout(rgba16f, binding = 0) writeonly uniform image3D facing[6]; // as in lib/voxels.glsl
uniform uint cell_count;
uniform int grid_size;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= cell_count) return;
    vec4 sums[6] = vec4[6](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    for (uint k = cell_of[i].y; k < cell_of[i].y + cell_of[i].z; ++k) {
        vec4 sent = piece_of[k].place.w * vec4(sent_by[k].rgb, 1.0);
        vec3 normal = piece_of[k].normal.xyz;
        for (int axis = 0; axis < 3; ++axis) {
            sums[2 * axis] += max(0.0, -normal[axis]) * sent;
            sums[2 * axis + 1] += max(0.0, normal[axis]) * sent;
        }
    }
    int number = int(cell_of[i].x);
    ivec3 at = ivec3(number % grid_size, number / grid_size % grid_size, number / (grid_size * grid_size));
    const vec4 most = vec4(60000.0); // of a half
    imageStore(facing[0], at, min(sums[0], most));
    imageStore(facing[1], at, min(sums[1], most));
    imageStore(facing[2], at, min(sums[2], most));
    imageStore(facing[3], at, min(sums[3], most));
    imageStore(facing[4], at, min(sums[4], most));
    imageStore(facing[5], at, min(sums[5], most));
}
