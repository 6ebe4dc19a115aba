// The surfaces in the cells of a grid, one after the other cell by cell, and the light they send.
// Included by the stages that light the grid.
struct Piece {
    vec4 place;  // metres from the scene's origin; its area in faces of a cell
    vec4 normal;
    vec4 albedo;
};
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Pieces { Piece piece_of[]; };
layout(std430, binding = 1) buffer Direct { vec4 direct_of[]; }; // what lamps give each
layout(std430, binding = 2) buffer Sent { vec4 sent_by[]; };     // what each sends
uniform uint piece_count;
