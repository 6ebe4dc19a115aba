// Clear the guesses of the shown picture before a picture's depth is scattered, and the list of
// pieces.
// In: nothing. Out: guess 0 (nothing landed) for four pixels an invocation; no pieces.
// Source: lib/seed_keys.glsl, what a guess is; lib/composite.glsl, what a piece is.
#define GROUP_X 256
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) writeonly buffer Seeds { uvec4 seeds[]; };
layout(std430, binding = 1) writeonly buffer Pieces { uint piece_groups[3]; uint piece_count; };
uniform int quads;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= quads) return;
    seeds[i] = uvec4(0u);
    if (i > 0) return;
    // No `a = b = 0u`: it reads b, which `writeonly` forbids (NVIDIA's compiler refuses it, Mesa's does not).
    piece_groups[0] = 0u;
    piece_groups[1] = 1u;
    piece_groups[2] = 1u;
    piece_count = 0u;
}
