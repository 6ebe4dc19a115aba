// A vertex of an even grid over the rendered picture, from border to border.
// In: the depth of its pixel and of a ring around it. Out: clip space; rendered pixel and inverse
// depth there, for perspective-correct interpolation.
// Source: openwarp of ILLIXR (Huzaifa et al. 2021): a vertex takes the nearest depth of a ring
// around it where that is clearly nearer than its own.
#include "warps/mesh_surface.glsl"
#include "warps/mesh_clip.glsl"
uniform int side;    // vertices on each axis
uniform ivec4 ring;  // pixels along x, along y, and along both to a place on a diagonal
uniform float nearer; // 1/m
out vec4 surface_point;

// Without depth: infinitely far.
float depth_at(ivec2 pixel) { return max(known_inverse_depth(pixel), 0.0); }

void main() {
    ivec2 at = ivec2(gl_VertexID % side, gl_VertexID / side);
    ivec2 pixel = min(at * rendered_size / (side - 1), rendered_size - 1); // whole numbers: below 2^24
    vec2 rendered = vec2(at * rendered_size) / float(side - 1);
    float own = depth_at(pixel), near = own;
    near = max(near, max(depth_at(pixel - ivec2(ring.x, 0)), depth_at(pixel + ivec2(ring.x, 0))));
    near = max(near, max(depth_at(pixel - ivec2(0, ring.y)), depth_at(pixel + ivec2(0, ring.y))));
    near = max(near, max(depth_at(pixel - ring.zw), depth_at(pixel + ring.zw)));
    float r = near - own > nearer ? near : own;
    surface_point = vec4(rendered, r, 1.0);
    gl_Position = clip_position(rendered, r);
}
