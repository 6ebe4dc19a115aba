// The draw calls that the GPU writes for itself, and the division of cut cells into chunks: CHUNK
// of them per invocation. The buffer starts with a dispatch of one invocation for each chunk.
struct Draw { uint count, instances, first, base_vertex, base_instance; };
layout(std430, binding = 2) buffer CellDraws { Draw cell_draws[]; };
layout(std430, binding = 3) buffer PieceDraws { Draw piece_draws[]; };
layout(std430, binding = 6) buffer Cut { uint chunk_groups[3]; uint cut_cells; };
const uint CHUNK = 8u;
const uint CHUNK_GROUP = 64u; // invocations in a work group

uint chunks_in(uint cells) { return (cells + CHUNK - 1u) / CHUNK; }
