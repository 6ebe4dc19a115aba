// The light on each block of pixels: shown colour and the model's albedo, summed over pixels where
// both show the same surface.
// In: the shown picture with holes and its inverse depth; the model's albedo and inverse depth.
// Out: one Light a block.
// Source: this project's; dividing albedo out: Barrow and Tenenbaum 1978, Recovering Intrinsic
// Scene Characteristics from Images.
layout(local_size_x = 16, local_size_y = 4) in;
uniform ivec2 shown_size;
#include "lib/relight.glsl"
layout(rgba16f) readonly uniform image2D warped;
layout(r32f) readonly uniform image2D warped_inverse_depth;
layout(rgba16f) readonly uniform image2D albedo;
layout(rgba32f) writeonly uniform image2D lights;
uniform ivec2 block_count;
uniform float same_depth;   // relative difference up to which two depths are one surface
uniform float same_surface; // and by which those of a block may be nearer than its farthest one

const float NOTHING = 1e30;

// The model's inverse depth where it agrees with the picture, NOTHING elsewhere.
float agreed(ivec2 p) {
    float shown = imageLoad(warped_inverse_depth, p).r, model = imageLoad(model_inverse_depth, p).r;
    bool inside = p.x < shown_size.x && p.y < shown_size.y;
    bool same = shown >= 0.0 && abs(shown - model) <= same_depth * (min(shown, model) + FLOOR);
    return inside && same ? model : NOTHING;
}

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (block.x >= block_count.x || block.y >= block_count.y) return;
    ivec2 corner = block * BLOCK;
    float depths[BLOCK * BLOCK];
    float farthest = NOTHING;
    for (int k = 0; k < BLOCK * BLOCK; ++k) {
        depths[k] = agreed(corner + ivec2(k % BLOCK, k / BLOCK));
        farthest = min(farthest, depths[k]);
    }
    float limit = min(farthest + same_surface * (farthest + FLOOR), 0.5 * NOTHING);
    vec3 seen = vec3(0.0), plain = vec3(0.0), place = vec3(0.0);
    vec4 across = vec4(0.0); // sums of both slopes, and their count
    float count = 0.0;
    for (int k = 0; k < BLOCK * BLOCK; ++k) {
        ivec2 p = corner + ivec2(k % BLOCK, k / BLOCK);
        if (depths[k] > limit) continue;
        seen += imageLoad(warped, p).rgb;
        plain += imageLoad(albedo, p).rgb;
        place += vec3(vec2(p) + 0.5, depths[k]);
        count += 1.0;
        float left = k % BLOCK > 0 ? depths[k - 1] : NOTHING, below = k >= BLOCK ? depths[k - BLOCK] : NOTHING;
        if (left <= limit) across.xz += vec2(depths[k] - left, 1.0);
        if (below <= limit) across.yw += vec2(depths[k] - below, 1.0);
    }
    place /= max(count, 1.0);
    vec3 normal = normal_at(place.xy, place.z, across.xy / max(across.zw, vec2(1.0)));
    const float share = 1.0 / float(BLOCK * BLOCK);
    vec3 point = point_at(place.xy, place.z);
    ivec2 light = ivec2(PARTS * block.x, block.y);
    imageStore(lights, light, vec4(share * seen, normal.x));
    imageStore(lights, light + ivec2(1, 0), vec4(share * plain, normal.y));
    imageStore(lights, light + ivec2(2, 0), vec4(point, normal.z));
}
