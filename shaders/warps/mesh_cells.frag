// Whole cells of the rendered surface, as mesh_cells.vert places them.
// In: rendered pixel and inverse depth, interpolated over a triangle. Out: linear colour with
// coverage 1; depth, larger is nearer.
// Source: Mark et al. 1997, Post-Rendering 3D Warping, section 3.
#include "warps/mesh_colour.glsl"
