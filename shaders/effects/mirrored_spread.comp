// Give blocks that show too little to tell the depth of the mirror image from around them.
// In: depths and their trust. Out: (depth, 1), 0 where none is near.
// Source: Shepard 1968, A Two-dimensional Interpolation Function for Irregularly-spaced Data.
#define GROUP_X 64
layout(local_size_x = GROUP_X, local_size_y = 1) in;
uniform ivec2 blocks;
layout(rg32f) readonly uniform image2D given;
layout(rg32f) writeonly uniform image2D written;
const int REACH = 8; // blocks

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (block.x >= blocks.x || block.y >= blocks.y) return;
    vec2 sum = vec2(0.0);
    for (int y = -REACH; y <= REACH; ++y)
        for (int x = -REACH; x <= REACH; ++x) {
            ivec2 at = block + ivec2(x, y);
            float away = float(x * x + y * y);
            if (away > float(REACH * REACH) || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, blocks))) continue;
            vec2 found = imageLoad(given, at).rg;
            float weight = found.y * inversesqrt(1.0 + away) / (1.0 + away);
            sum += weight * vec2(found.x, 1.0);
        }
    imageStore(written, block, sum.y > 1e-6 ? vec4(sum.x / sum.y, 1.0, 0.0, 0.0) : vec4(0.0));
}
