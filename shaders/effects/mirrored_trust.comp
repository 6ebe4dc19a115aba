// How far both layers explain the other pictures better than surfaces alone do: 0 for no better.
// PASS 0 sums over each block what they leave unexplained, and what surfaces alone do; PASS 1 sums
// over 3x3 blocks, and compares.
// In: the aligned pictures, places in them, the light in mirrors. Out: per block 0 to 1.
// Source: none.
#define GROUP_X 64
layout(local_size_x = GROUP_X, local_size_y = 1) in;
#include "effects/mirrored.glsl"
uniform ivec2 blocks;
#if PASS == 0
uniform sampler2DArray aligned;
uniform sampler2D light_before;
uniform vec2 rendered_pixel; // 1 / rendered_size
uniform int pictures;
layout(rg32f, binding = 1) readonly uniform image2DArray given; // places of mirrored_places.comp
layout(rg32f) writeonly uniform image2D written;

// What a surface may differ by where pictures do not fit to the pixel: its contrast to the next pixel.
vec3 slack_at(ivec2 pixel, vec3 here) {
    vec3 most = vec3(0.0);
    for (int side = 0; side < 4; ++side) {
        ivec2 step = (side & 1) == 0 ? ivec2(side - 1, 0) : ivec2(0, side - 2);
        ivec2 beside = clamp(pixel + step, ivec2(0), rendered_size - 1);
        most = max(most, abs(texelFetch(aligned, ivec3(beside, 0), 0).rgb - here));
    }
    return most;
}

void visit(ivec2 block) {
    vec2 sum = vec2(0.0);
    for (int index = 0; index < BLOCK * BLOCK; ++index) {
        ivec2 pixel = block * BLOCK + ivec2(index % BLOCK, index / BLOCK);
        if (any(greaterThanEqual(pixel, rendered_size))) continue;
        vec3 here = texelFetch(aligned, ivec3(pixel, 0), 0).rgb;
        vec4 light = texelFetch(light_before, pixel, 0);
        if (light.a < 0.5) continue;
        vec3 slack = slack_at(pixel, here);
        for (int k = 1; k < pictures; ++k) {
            vec4 there = texelFetch(aligned, ivec3(pixel, k), 0);
            vec2 place = imageLoad(given, ivec3(pixel, k)).rg;
            vec4 seen = textureLod(light_before, place * rendered_pixel, 0.0);
            if (there.a < 0.5 || place.x < 0.0 || seen.a < 0.5) continue;
            vec3 differs = here - there.rgb, left = differs - light.rgb + seen.rgb / seen.a;
            left = max(abs(left) - slack, 0.0);
            differs = max(abs(differs) - slack, 0.0);
            sum += min(vec2(left.r + left.g + left.b, differs.r + differs.g + differs.b), vec2(1e4));
        }
    }
    imageStore(written, block, vec4(sum, 0.0, 0.0));
}
#else
layout(rg32f) readonly uniform image2D given;
layout(r32f) writeonly uniform image2D written;
const float EXPLAINED = 0.8; // of what surfaces leave, both layers may leave; from half of that on they are trusted
const float LEAST = 0.01;    // that surfaces must leave, a pixel

void visit(ivec2 block) {
    vec2 sum = vec2(0.0);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) sum += imageLoad(given, clamp(block + ivec2(x, y), ivec2(0), blocks - 1)).rg;
    float shown = clamp((EXPLAINED * sum.g - sum.r) / (0.3 * sum.g + 1e-9), 0.0, 1.0);
    imageStore(written, block, vec4(sum.g > LEAST * float(9 * BLOCK * BLOCK) ? shown : 0.0));
}
#endif

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (block.x >= blocks.x || block.y >= blocks.y) return;
    visit(block);
}
