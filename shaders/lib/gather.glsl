// One bilinear sample of the rendered picture. Its colour is premultiplied by coverage there (a
// hole is 0, 0, 0, 0), so holes never bleed: covered pixels are averaged, and the result is covered
// where their weight is at least a half.
uniform sampler2D rendered_colour;
uniform ivec2 rendered_size;
uniform vec2 rendered_pixel; // 1 / rendered_size

// llvmpipe checks the bounds of every load of a uniform, with a branch, and hoists none out of the
// loop over rows: copies made before the loop took a third off the fused warps. prepare_sampling()
// makes them.
vec2 rendered_extent;
#ifdef TEXELS
// The fused warps need one channel of each sample. Four such loads take llvmpipe two thirds of the
// time of a sample, because its sampler computes all four channels. GPUs use the sampler.
layout(rgba16f) readonly uniform image2D rendered_texels;
vec2 texels_end;

void prepare_sampling() {
    rendered_extent = vec2(rendered_size);
    texels_end = vec2(imageSize(rendered_texels)) - 0.5;
}

vec4 bilinear(vec2 p) {
    vec2 at = clamp(p, vec2(0.5), texels_end) - 0.5;
    vec2 low = floor(at), part = at - low;
    ivec2 texel = ivec2(low);
    vec4 a = imageLoad(rendered_texels, texel), b = imageLoad(rendered_texels, texel + ivec2(1, 0));
    vec4 c = imageLoad(rendered_texels, texel + ivec2(0, 1)), d = imageLoad(rendered_texels, texel + ivec2(1, 1));
    return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}
#else
vec2 per_pixel;

void prepare_sampling() {
    rendered_extent = vec2(rendered_size);
    per_pixel = rendered_pixel;
}

vec4 bilinear(vec2 p) {
    return textureLod(rendered_colour, p * per_pixel, 0.0);
}
#endif

#ifdef CATMULL_ROM
vec4 colour_texel(ivec2 texel) {
#ifdef TEXELS
    return imageLoad(rendered_texels, texel);
#else
    return texelFetch(rendered_colour, texel, 0);
#endif
}
#include "lib/catmull_rom.glsl"

vec4 sampled(vec2 p) {
    return catmull_rom(p, ivec2(rendered_extent));
}
#else
#ifdef FOVEATED
#include "lib/fovea.glsl"

// Columns or rows of the rim over a distance from the centre of the outermost sharp pixel: the first
// step is from there to the rim's first centre.
vec2 rim_steps(vec2 away) {
    float first = 0.5 * float(rim) + 0.5;
    return min(away, first) / first + max(away - first, 0.0) * of_rim;
}

// Where a place lies in the coarser picture: linear between the centres of its pixels.
vec2 grid_place(vec2 p) {
    vec2 low = vec2(sharp_from) + 0.5, high = vec2(sharp_from + sharp) - 0.5;
    vec2 inside = vec2(before) + clamp(p, low, high) - vec2(sharp_from);
    return inside + rim_steps(max(p - high, 0.0)) - rim_steps(max(low - p, 0.0));
}

vec4 sampled(vec2 p) {
    return bilinear(grid_place(p));
}
#else
vec4 sampled(vec2 p) {
    return bilinear(p);
}
#endif
#endif

bool in_rendered(vec2 p) {
    return p.x >= 0.0 && p.y >= 0.0 && p.x < rendered_extent.x && p.y < rendered_extent.y;
}

vec4 covered_average(vec2 p) {
    vec4 sum = sampled(p);
    return sum.a >= 0.5 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}
