// Bring a picture that is coarser beyond a sharp rectangle back to its own pixels: linear between the
// centres of the pixels around, without what is not covered and (DEPTH 1) without another surface
// than that of the pixel that holds this one.
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

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= picture_size.x || p.y >= picture_size.y) return;
    ivec2 own = holder_of(p);
    vec4 held = imageLoad(foveated, own);
    // From the holder's centre, in half pixels; 0 in the sharp rectangle.
    ivec2 away = 2 * (p - first_of(own)) + 1 - count_of(own);
    ivec2 other = clamp(own + sign(away), ivec2(0), small_size() - 1);
    vec2 part = vec2(abs(away)) / vec2(count_of(own) + count_of(other)); // of the way between both centres
    part = vec2(other.x == own.x ? 0.0 : part.x, other.y == own.y ? 0.0 : part.y);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int k = 0; k < 4; ++k) {
        bvec2 takes = bvec2((k & 1) != 0, (k & 2) != 0);
        vec4 there = imageLoad(foveated, ivec2(takes.x ? other.x : own.x, takes.y ? other.y : own.y));
        float weight = (takes.x ? part.x : 1.0 - part.x) * (takes.y ? part.y : 1.0 - part.y);
#if DEPTH
        weight = there.r >= 0.0 && one_surface(there.r, held.r) ? weight : 0.0;
#else
        weight = there.a > 0.0 ? weight : 0.0;
#endif
        sum += weight * there;
        weights += weight;
    }
#if DEPTH
    imageStore(picture, p, held.r < 0.0 || part == vec2(0.0) ? held : sum / weights);
#else
    imageStore(picture, p, held.a <= 0.0 || part == vec2(0.0) ? held : sum / weights);
#endif
}
