// A whole cell of the late surface: two triangles with the late inverse depth at its corners.
// In: the list of cells. Out: clip space; rendered pixel and inverse depth there, for perspective-correct interpolation.
// Source: Mark et al. 1997, Post-Rendering 3D Warping, section 3 (the picture as a mesh of triangles).
#include "warps/mesh_surface.glsl"
#include "warps/mesh_clip.glsl"
layout(std430, binding = 4) readonly buffer Cells { uint cells[]; };
out vec2 drawn;
out float drawn_inverse_depth;
#if ADAPTIVE
uniform float overlap; // rendered pixels by which cells of several pixels reach over their neighbours
flat out float held_back;
#endif

void main() {
    uint cell = cells[gl_VertexID >> 2];
    ivec2 origin = ivec2(cell & 0x3FFFu, cell >> 14u & 0x3FFFu);
    int side = 1 << int(cell >> 28u);
    ivec2 corner = ivec2(gl_VertexID & 1, gl_VertexID >> 1 & 1);
    ivec2 pixel = origin - 1 + corner * side;
    drawn = clamp(vec2(pixel) + 0.5, vec2(0.0), vec2(late_size));
    drawn_inverse_depth = known_inverse_depth(pixel);
#if ADAPTIVE
    // Beside a large cell lie vertices that it does not have: what it is off there would show as a crack. Its own plane goes on a
    // little way, and is held back in the depth test alone, so that finer cells win. The edge of a surface never belongs to a large cell.
    held_back = 1.0 - float(cell >> 28u) / 512.0;
    float out_by = side > 1 ? overlap : 0.0;
    float along_x = known_inverse_depth(origin - 1 + ivec2(1 - corner.x, corner.y) * side);
    float along_y = known_inverse_depth(origin - 1 + ivec2(corner.x, 1 - corner.y) * side);
    drawn += out_by * vec2(2 * corner - 1);
    drawn_inverse_depth = max(drawn_inverse_depth + out_by / float(side) * (2.0 * drawn_inverse_depth - along_x - along_y), 0.0);
#endif
    gl_Position = clip_position(drawn, drawn_inverse_depth);
}
