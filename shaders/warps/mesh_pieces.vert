// A cell that is not one surface: a quarter for each corner that has depth, at that corner's own
// depth where the cell is cut.
// In: the list of cut cells with their joined edges, or of their triangles. Out: as
// mesh_cells.vert; which pixel a quarter belongs to.
// Source: Mark 1999, Post-Rendering 3D Image Warping, 3.3: a cut surface ends half a pixel from its
// last centre.
#include "warps/mesh_surface.glsl"
#include "warps/mesh_quarters.glsl"
#include "warps/mesh_clip.glsl"
layout(std430, binding = 5) readonly buffer Pieces { uint pieces[]; };
#if ADAPTIVE
layout(std430, binding = 7) readonly buffer Triangles { uint triangles[]; };
#endif
out vec4 surface_point;
// Centre of the pixel it belongs to; the direction from there in which its colour may change along
// x, along y, 0 for none
flat out vec4 owner;

void main() {
#if ADAPTIVE
    uint triangle = triangles[gl_VertexID / 3], which = triangle >> 1u;
    int vertex = gl_VertexID % 3 + int(triangle & 1u); // 0 1 2, or 2 1 3
    if ((triangle & 1u) != 0u && vertex < 3) vertex = 3 - vertex;
#else
    uint which = uint(gl_VertexID >> 2);
    int vertex = gl_VertexID & 3;
#endif
    Quarter mine = quarter(pieces[which >> 2u], int(which & 3u));
    vec3 point = point_of(mine, ivec2(vertex & 1, vertex >> 1));
    surface_point = vec4(point, 1.0);
    owner = vec4(vec2(clamp(mine.cell - 1 + mine.corner, ivec2(0), rendered_size - 1)) + 0.5, mine.towards);
    gl_Position = mine.own >= 0.0 ? clip_position(point.xy, point.z) : vec4(0.0, 0.0, 0.0, -1.0);
}
