// Clear the keys of the shown picture before a scatter.
// In: nothing. Out: key 0 (nothing landed) for four pixels an invocation, and no tie to settle.
// Source: docs/adding-a-warp.md, what a scatter warp keeps between pictures.
#define GROUP_X 256
layout(local_size_x = GROUP_X) in;
layout(std430, binding = 0) writeonly buffer Keys { uvec4 keys[]; };
layout(std430, binding = 1) writeonly buffer Ties { uint tie_groups[3]; };
uniform int quads;
uniform ivec2 tie_dispatch;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= quads) return;
    keys[i] = uvec4(0u);
    if (i == 0) {
        tie_groups[0] = uint(tie_dispatch.x);
        tie_groups[1] = uint(tie_dispatch.y);
        tie_groups[2] = 0u;
    }
}
