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
    ivec2 other = clamp(own + sign(away), ivec2(0), small_size - 1);
    vec2 part = vec2(abs(away)) / vec2(count_of(own) + count_of(other)); // of the way between both centres
    part = vec2(other.x == own.x ? 0.0 : part.x, other.y == own.y ? 0.0 : part.y);
    vec4 there[4] = vec4[4](
        held,
        imageLoad(foveated, ivec2(other.x, own.y)),
        imageLoad(foveated, ivec2(own.x, other.y)),
        imageLoad(foveated, other)
    );
    vec2 rest = 1.0 - part;
    vec4 weight = vec4(rest.x * rest.y, part.x * rest.y, rest.x * part.y, part.x * part.y);
#if DEPTH
    for (int k = 1; k < 4; ++k) weight[k] = there[k].r >= 0.0 && one_surface(there[k].r, held.r) ? weight[k] : 0.0;
    bool is_hole = held.r < 0.0;
#else
    for (int k = 1; k < 4; ++k) weight[k] = there[k].a > 0.0 ? weight[k] : 0.0;
    bool is_hole = held.a <= 0.0;
#endif
    vec4 sum = weight.x * there[0] + weight.y * there[1] + weight.z * there[2] + weight.w * there[3];
    imageStore(picture, p, is_hole || weight.x == 1.0 ? held : sum / dot(weight, vec4(1.0)));
}
