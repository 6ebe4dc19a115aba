// Compute all levels of the pyramid above a small one, and complete each from the one above it, in
// one work group: as passes of their own these levels take a GPU 10 microseconds each and have
// nothing to do.
// In: a level of at most 64 x 64 texels (`start_size`), not the first. Out: the next one, completed.
// Source: as of lib/pull.glsl and lib/push.glsl.
#define THREADS 256
layout(local_size_x = THREADS) in;
layout(rgba16f) readonly uniform image2D below_colour;
layout(rgba32f) readonly uniform image2D below_depth;
layout(rgba16f) writeonly uniform image2D level_colour;
layout(rgba32f) writeonly uniform image2D level_depth;
uniform ivec2 start_size;
uniform int levels;        // above it; the last one has one texel
uniform int local_levels;  // of those, as lib/push_pull.glsl has it
// Of local levels, and of the others:
uniform vec2 least_borders, least_shares;
uniform float first_pixels; // along a side of a texel of the first level above

const int MOST_LEVELS = 6;
const int TEXELS = 1365; // 32^2 + 16^2 + .. + 1
const float crack_border = 1.0;
// The colours as two pairs of halves; inverse depth, share of empty pixels and border.
shared uvec2 colours[TEXELS];
shared float depths[3 * TEXELS];

float least_border, texel_pixels;
ivec2 below_size, above_size;
int below_first, above_first; // index of a level's first texel; -1: in the image

vec4 colour_of(int index) {
    uvec2 halves = colours[index];
    return vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
}

vec3 depth_of(int index) {
    return vec3(depths[3 * index], depths[3 * index + 1], depths[3 * index + 2]);
}

void keep(int index, vec4 colour, vec3 depth) {
    colours[index] = uvec2(packHalf2x16(colour.rg), packHalf2x16(colour.ba));
    depths[3 * index] = depth.x;
    depths[3 * index + 1] = depth.y;
    depths[3 * index + 2] = depth.z;
}

bool is_below(ivec2 texel) {
    return all(lessThan(uvec2(texel), uvec2(below_size)));
}

vec4 colour_below(ivec2 texel) {
    if (below_first < 0) return imageLoad(below_colour, texel);
    return is_below(texel) ? colour_of(below_first + texel.y * below_size.x + texel.x) : vec4(0.0);
}

vec3 depth_below(ivec2 texel) {
    if (below_first < 0) return imageLoad(below_depth, texel).rgb;
    return is_below(texel) ? depth_of(below_first + texel.y * below_size.x + texel.x) : vec3(0.0);
}

vec4 colour_above(ivec2 texel) {
    return colour_of(above_first + texel.y * above_size.x + texel.x);
}

vec3 depth_above(ivec2 texel) {
    return depth_of(above_first + texel.y * above_size.x + texel.x);
}
#define FROM_PICTURE 0
#include "lib/pull.glsl"
#include "lib/push.glsl"

Texel texel_from_below(ivec2 texel) {
    ivec2 from = 2 * texel - 1;
    Texels a = row_from(from), b = row_from(from + ivec2(0, 1)), c = row_from(from + ivec2(0, 2)), d = row_from(from + ivec2(0, 3));
    vec2 lower = KERNEL.x * holes_of(a, from) + KERNEL.y * holes_of(b, from + ivec2(0, 1));
    vec2 all = lower + KERNEL.y * holes_of(c, from + ivec2(0, 2)) + KERNEL.x * holes_of(d, from + ivec2(0, 3));
    return all.x > 0.0 ? pulled(texel, a, b, c, d, all.x, all.y) : Texel(vec4(0.0), vec3(0.0));
}

void main() {
    ivec2 sizes[MOST_LEVELS];
    int firsts[MOST_LEVELS], next = 0, thread = int(gl_LocalInvocationID.x);
    below_size = start_size;
    below_first = -1;
    for (int level = 0; level < levels; ++level) {
        ivec2 size = (below_size + 1) / 2;
        sizes[level] = size;
        firsts[level] = next;
        least_border = least_borders[level < local_levels ? 0 : 1];
        texel_pixels = first_pixels * float(1 << level);
        for (int index = thread; index < size.x * size.y; index += THREADS) {
            Texel made = texel_from_below(ivec2(index % size.x, index / size.x));
            keep(next + index, made.colour, made.depth);
        }
        barrier();
        below_size = size;
        below_first = next;
        next += size.x * size.y;
    }
    for (int level = levels - 2; level >= 0; --level) {
        above_size = sizes[level + 1];
        above_first = firsts[level + 1];
        least_border = least_borders[level + 1 < local_levels ? 0 : 1];
        texel_pixels = first_pixels * float(1 << level);
        float least_holes = least_shares[level < local_levels ? 0 : 1];
        for (int index = thread; index < sizes[level].x * sizes[level].y; index += THREADS) {
            int at = firsts[level] + index;
            vec3 depth = depth_of(at);
            if (depth.g <= 0.0) continue;
            Texel made = pushed(ivec2(index % sizes[level].x, index / sizes[level].x), colour_of(at), depth, least_holes);
            keep(at, made.colour, made.depth);
        }
        barrier();
    }
    for (int index = thread; index < sizes[0].x * sizes[0].y; index += THREADS) {
        ivec2 texel = ivec2(index % sizes[0].x, index / sizes[0].x);
        imageStore(level_colour, texel, colour_of(index));
        imageStore(level_depth, texel, vec4(depth_of(index), 0.0));
    }
}
