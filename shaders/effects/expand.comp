// Bring a picture that is coarser beyond a sharp rectangle back to its own pixels: linear between the
// centres of the pixels around, without what is not covered and (DEPTH 1) without another surface
// than that of the pixel that holds this one.
// INSET 1: the picture is coarse everywhere, and a sharp one of a rectangle lies beside it; its colour
// begins over the width of a coarse pixel, so that no line is seen, and its depth at once.
// In: rgba16f colour with coverage in alpha, or r32f inverse depth in 1/m, on the grid of
// lib/fovea.glsl. Out: the same for each pixel of the picture; the sharp rectangle bit for bit.
// Source: none; bilinear in two steps whose lengths differ. Guenter et al. 2012, Foveated 3D Graphics
// (blended insets).
layout(local_size_x = 64, local_size_y = 1) in;
#include "lib/fovea.glsl"
#if DEPTH
layout(r32f) readonly uniform image2D foveated;
layout(r32f) writeonly uniform image2D picture;
#else
layout(rgba16f) readonly uniform image2D foveated;
layout(rgba16f) writeonly uniform image2D picture;
#endif
#if INSET
vec4 inset_over(vec4 coarse, ivec2 p) {
    ivec2 at = p - inset_from, inner = min(at, inset_size - 1 - at);
    int inside = min(inner.x, inner.y);
    vec4 own = imageLoad(foveated, inset_at + clamp(at, ivec2(0), inset_size - 1));
#if DEPTH
    float part = 1.0;
#else
    float part = coarse.a > 0.0 && own.a > 0.0 ? min((float(inside) + 0.5) * of_rim, 1.0) : 1.0;
#endif
    return inside < 0 ? coarse : part == 1.0 ? own : mix(coarse, own, part);
}
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
    vec4 found = is_hole || weight.x == 1.0 ? held : sum / dot(weight, vec4(1.0));
#if INSET
    found = inset_over(found, p);
#endif
    imageStore(picture, p, found);
}
