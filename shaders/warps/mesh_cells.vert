// A whole cell of the rendered surface: two triangles with the rendered inverse depth at its
// corners.
// In: the list of cells. Out: clip space; rendered pixel and inverse depth there, for
// perspective-correct interpolation.
// Source: Mark et al. 1997, Post-Rendering 3D Warping, section 3 (the picture as a mesh of
// triangles).
#include "warps/mesh_surface.glsl"
#include "warps/mesh_clip.glsl"
layout(std430, binding = 4) readonly buffer Cells { uvec2 cells[]; };
// Rendered pixel, inverse depth, and the shown depth's weight in the depth test: one vector is
// faster on llvmpipe
out vec4 surface_point;
#if ADAPTIVE
uniform float overlap; // rendered pixels by which merged cells extend over their neighbours
#endif

void main() {
    uvec2 cell = cells[gl_VertexID >> 2];
    ivec2 origin = ivec2(cell.x & 0xFFFFu, cell.x >> 16u), side = ivec2(cell.y & 0xFFFFu, cell.y >> 16u);
    ivec2 corner = ivec2(gl_VertexID & 1, gl_VertexID >> 1 & 1);
    ivec2 pixel = origin - 1 + corner * side;
    vec2 rendered = clamp(vec2(pixel) + 0.5, vec2(0.0), vec2(rendered_size));
    float r = known_inverse_depth(pixel), held_back = 1.0;
#if ADAPTIVE
    // A large cell has neighbours with vertices that it lacks: its deviation there would show as a
    // crack. So its plane extends a little, and is held back in the depth test alone, so that finer
    // cells win. The edge of a surface never belongs to a large cell.
    int larger = max(side.x, side.y);
    held_back = 1.0 - float(larger - 1) / 2048.0;
    float out_by = larger > 1 ? overlap : 0.0;
    float along_x = known_inverse_depth(origin - 1 + ivec2(1 - corner.x, corner.y) * side);
    float along_y = known_inverse_depth(origin - 1 + ivec2(corner.x, 1 - corner.y) * side);
    vec2 slopes = (r - vec2(along_x, along_y)) / vec2(side);
    rendered += out_by * vec2(2 * corner - 1);
    r = max(r + out_by * (slopes.x + slopes.y), 0.0);
#endif
    surface_point = vec4(rendered, r, held_back);
    gl_Position = clip_position(rendered, r);
}
