// Try depths of the mirror image for each block: at which do the edges of the pictures agree?
// In: the edges that are left, the surface. Out: per plane and block the sum of differences, and of
// how many samples. Plane 0 is the surface itself, plane PLANES infinitely far.
// Source: Sinha et al. 2012, section 4; Collins 1996, A Space-Sweep Approach to True Multi-Image
// Matching.
#define GROUP_X 64
layout(local_size_x = GROUP_X, local_size_y = 1) in;
#include "effects/mirrored.glsl"
uniform sampler2DArray edges;
uniform vec2 edges_pixel; // 1 / (their size in rendered pixels)
layout(rg16f, binding = 2) writeonly uniform image2DArray written;
uniform ivec2 blocks;
uniform int pictures;
uniform vec3 eyes[4]; // of the pictures; that of the rendered one is not used
const float MOST = 0.1; // of one difference

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= blocks.x) return;
    if (at.y >= blocks.y * (PLANES + 1)) return;
    ivec2 block = ivec2(at.x, at.y % blocks.y);
    int plane = at.y / blocks.y;
    // The surface around the middle of the block, as a linear function of the place.
    ivec2 middle = min(block * BLOCK + BLOCK / 2, rendered_size - 1);
    float own = depth_at(middle);
    vec2 lower = vec2(depth_at(middle - ivec2(1, 0)), depth_at(middle - ivec2(0, 1)));
    vec2 upper = vec2(depth_at(middle + ivec2(1, 0)), depth_at(middle + ivec2(0, 1)));
    bvec2 even = bvec2(of_one_surface(lower.x, own) && of_one_surface(own, upper.x), of_one_surface(lower.y, own) && of_one_surface(own, upper.y));
    vec2 slope = mix(vec2(0.0), 0.5 * (upper - lower), even);
    vec3 surface = vec3(slope, own - dot(slope, vec2(middle) + 0.5));
    float image = own * (1.0 - float(plane) / float(PLANES)), sum = 0.0, count = 0.0;
    for (int pixel = 0; pixel < BLOCK * BLOCK / 4 && is_depth(own); ++pixel) {
        ivec2 texel = block * BLOCK + 2 * ivec2(pixel % (BLOCK / 2), pixel / (BLOCK / 2));
        float here = depth_at(texel);
        vec3 from = vec3(vec2(texel) + 1.0, 1.0);
        vec3 mine = textureLod(edges, vec3(from.xy * edges_pixel, 0.0), 0.0).rgb;
        if (mine.z <= 0.99 || !is_depth(here)) continue;
        for (int k = 1; k < pictures; ++k) {
            vec3 q = crossing(from, plane == 0 ? here : min(image, here), here, dot(surface, eyes[k]), eyes[k]);
            vec2 place = q.xy / q.z;
            vec3 other = textureLod(edges, vec3(place * edges_pixel, float(k)), 0.0).rgb;
            bool counts = q.z > 0.0 && in_rendered(place) && other.z > 0.99;
            sum += counts ? min(abs(mine.x - other.x) + abs(mine.y - other.y), MOST) : 0.0;
            count += float(counts);
        }
    }
    imageStore(written, ivec3(block, plane), vec4(sum, count, 0.0, 0.0));
}
