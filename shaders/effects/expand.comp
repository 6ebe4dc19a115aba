// Bring a picture that is coarser beyond a sharp rectangle back to its own pixels: linear between the
// centres of the pixels around, without what is not covered and (DEPTH 1) without another surface
// than that of the pixel that holds this one. One invocation writes all that one pixel holds, so
// that each of its neighbours is loaded once: llvmpipe takes the longest for loads.
// In: rgba16f colour with coverage in alpha, or r32f inverse depth in 1/m, on the grid of
// lib/fovea.glsl. Out: the same for each pixel of the picture; the sharp rectangle bit for bit.
// Source: none; bilinear in two steps whose lengths differ.
layout(local_size_x = 64, local_size_y = 1) in;
#include "lib/fovea.glsl"
#if DEPTH
layout(r32f) readonly uniform image2D foveated;
layout(r32f) writeonly uniform image2D picture;
#else
layout(rgba16f) readonly uniform image2D foveated;
layout(rgba16f) writeonly uniform image2D picture;
#endif

bool is_covered(vec4 texel) {
#if DEPTH
    return texel.r >= 0.0;
#else
    return texel.a > 0.0;
#endif
}

// 1 for a pixel beside one that is held which may be averaged with it.
float counts(vec4 beside, vec4 held) {
#if DEPTH
    return is_covered(beside) && one_surface(beside.r, held.r) ? 1.0 : 0.0;
#else
    return is_covered(beside) ? 1.0 : 0.0;
#endif
}

void main() {
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (own.x >= small_size.x || own.y >= small_size.y) return;
    ivec2 first = first_of(own), count = count_of(own), half_way = (count + 1) >> 1;
    vec4 held = imageLoad(foveated, own);
    for (int quarter = 0; quarter < 4; ++quarter) {
        ivec2 upper = ivec2(quarter & 1, quarter >> 1), begin = upper * half_way;
        ivec2 end = min(half_way + upper * (count - half_way), picture_size - first);
        ivec2 other = clamp(own + 2 * upper - 1, ivec2(0), small_size - 1);
        vec4 beside = imageLoad(foveated, ivec2(other.x, own.y)), over = imageLoad(foveated, ivec2(own.x, other.y));
        vec4 across = imageLoad(foveated, other);
        vec3 known = is_covered(held) ? vec3(counts(beside, held), counts(over, held), counts(across, held)) : vec3(0.0);
        // Of the way between both centres, for half a pixel from the held one's.
        vec2 share = mix(1.0 / vec2(count + count_of(other)), vec2(0.0), equal(other, own));
        for (int y = begin.y; y < end.y; ++y)
            for (int x = begin.x; x < end.x; ++x) {
                vec2 part = vec2(abs(2 * ivec2(x, y) + 1 - count)) * share, rest = 1.0 - part;
                vec3 weight = known * vec3(part.x * rest.y, rest.x * part.y, part.x * part.y);
                float whole = rest.x * rest.y, total = whole + weight.x + weight.y + weight.z;
                vec4 sum = whole * held + weight.x * beside + weight.y * over + weight.z * across;
                imageStore(picture, first + ivec2(x, y), total == whole ? held : sum / total);
            }
    }
}
