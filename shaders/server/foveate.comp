// Make a picture coarser beyond its sharp rectangle: colour (DEPTH 0) is the mean of the covered
// pixels that one of the rim holds, depth (DEPTH 1) the mean over the nearest surface among them.
// In: rgba16f colour with coverage in alpha, or r32f inverse depth in 1/m, -1 in holes. Out: the same
// on the grid of lib/fovea.glsl; the sharp rectangle bit for bit.
// Source: Patney et al. 2016, Towards Foveated Rendering for Gaze-Tracked Virtual Reality (average,
// not sample, what the rim drops: else it shimmers).
layout(local_size_x = 64, local_size_y = 1) in;
#include "lib/fovea.glsl"
#if DEPTH
layout(r32f) readonly uniform image2D picture;
layout(r32f) writeonly uniform image2D foveated;
#else
layout(rgba16f) readonly uniform image2D picture;
layout(rgba16f) writeonly uniform image2D foveated;
#endif

void main() {
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (own.x >= small_size.x || own.y >= small_size.y) return;
    ivec2 first = first_of(own), end = first + count_of(own);
#if DEPTH
    float nearest = -1.0, sum = 0.0, count = 0.0;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) nearest = max(nearest, imageLoad(picture, ivec2(x, y)).r);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) {
            float depth = imageLoad(picture, ivec2(x, y)).r;
            bool same = depth >= 0.0 && one_surface(depth, nearest);
            sum += same ? depth : 0.0;
            count += same ? 1.0 : 0.0;
        }
    imageStore(foveated, own, vec4(count > 0.0 ? sum / count : -1.0));
#else
    vec4 sum = vec4(0.0);
    float count = 0.0;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) {
            vec4 colour = imageLoad(picture, ivec2(x, y));
            sum += colour.a > 0.0 ? colour : vec4(0.0);
            count += colour.a > 0.0 ? 1.0 : 0.0;
        }
    imageStore(foveated, own, count > 0.0 ? sum / count : vec4(0.0));
#endif
}
