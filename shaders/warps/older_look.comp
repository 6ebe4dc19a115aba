// Look each shown surface up in an older frame, once, where the depth that was found says it lay.
// In: the shown picture's inverse depth, an older frame. Out: the older frame's colour for each shown
// pixel, alpha 1 where that frame saw the same surface.
// Source: this project's; the reprojection of temporal antialiasing (Karis 2014, High-Quality
// Temporal Supersampling), from frames that are kept.
#define ROWS 8
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
layout(r32f) readonly uniform image2D shown_inverse_depth;
layout(r32f) readonly uniform image2D older_inverse_depth;
layout(rgba16f) writeonly uniform image2D looked_up;
uniform ivec2 shown_size;
uniform ivec2 rendered_size;
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance
#ifdef TEXELS
layout(rgba16f) readonly uniform image2D older_colour; // takes llvmpipe half the time of fetches
vec4 colour_texel(ivec2 texel) {
    return imageLoad(older_colour, texel);
}
#else
uniform sampler2D older_colour;
vec4 colour_texel(ivec2 texel) {
    return texelFetch(older_colour, texel, 0);
}
#endif
#include "lib/catmull_rom.glsl"

// Copies: llvmpipe checks the bounds of each load of a uniform, and hoists none out of the loop.
ivec2 extent;
float tolerance, least;

bool steps(float from, float to) {
    return abs(to - from) > tolerance * min(from, to) + least;
}

// The older frame's inverse depth at a pixel; with FRINGED the pixel beside a nearer surface
// belongs to that, as in iterative_fringe.comp.
float held_at(ivec2 pixel) {
    float own = imageLoad(older_inverse_depth, pixel).r;
#ifdef FRINGED
    float beside = max(imageLoad(older_inverse_depth, pixel - ivec2(1, 0)).r, imageLoad(older_inverse_depth, pixel + ivec2(1, 0)).r);
    float above = max(imageLoad(older_inverse_depth, pixel - ivec2(0, 1)).r, imageLoad(older_inverse_depth, pixel + ivec2(0, 1)).r);
    float nearest = max(beside, above);
    own = own >= 0.0 && nearest > own && nearest < 1e30 && steps(own, nearest) ? nearest : own;
#endif
    return own;
}

vec4 looked_up_at(vec3 q, float depth) {
    vec2 p = q.xy / q.z;
    float expected = depth / q.z, held = held_at(ivec2(floor(p)));
    vec4 sum = catmull_rom(p, extent);
    bool saw = depth >= 0.0 && q.z > 0.0 && inside(p, extent) && held >= 0.0 && !steps(held, expected);
    return saw && sum.a >= 0.5 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}

void main() {
    ivec2 first = first_pixel(), size = shown_size;
    if (first.x >= size.x) return;
    extent = rendered_size;
    tolerance = depth_tolerance;
    least = depth_tolerance * depth_floor;
    vec3 start = vec3(vec2(first) + 0.5, 1.0), base = H * start, up = H[1], parallax = e;
#ifdef SCANOUT
    float row_share = 1.0 / float(size.y);
    vec3 base_linear = H_linear * start, base_square = H_square * start, up_linear = H_linear[1], up_square = H_square[1];
    vec3 first_e = e, linear_e = e_linear, square_e = e_square;
#endif
    for (int row = 0; row < ROWS; ++row) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.y >= size.y) break;
        vec3 here = base + up * float(row);
#ifdef SCANOUT
        float t = 1.0 - (start.y + float(row)) * row_share;
        here += t * (base_linear + up_linear * float(row) + t * (base_square + up_square * float(row)));
        parallax = first_e + t * (linear_e + t * square_e);
#endif
        float depth = imageLoad(shown_inverse_depth, pixel).r; // -1 in holes
        imageStore(looked_up, pixel, looked_up_at(here + parallax * depth, depth));
    }
}
