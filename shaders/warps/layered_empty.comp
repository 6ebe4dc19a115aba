// Empties the guesses of the shown picture before a picture's depth is scattered.
// In: nothing. Out: guess 0 (nothing landed) for four pixels an invocation.
// Source: lib/seed_keys.glsl, what a guess is.
#define GROUP_X 256
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) writeonly buffer Seeds { uvec4 seeds[]; };
uniform int quads;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= quads) return;
    seeds[i] = uvec4(0u);
}
