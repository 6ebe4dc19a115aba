// The colour of what is shown in older frames of the eye: where the depth that was found says that it
// lay, if they saw the same surface there. Who includes it has OLDER, the number of those frames, and
// shown_size.
// Source: this project's; the reprojection of temporal antialiasing (Karis 2014, High-Quality
// Temporal Supersampling), from frames that are kept.
layout(r32f) readonly uniform image2D shown_inverse_depth;
layout(r32f) readonly uniform image2D older_inverse_depth[OLDER];
// The warp map from the shown view to that of each frame, as in lib/warp_map.glsl.
uniform mat3 older_H[OLDER];
uniform vec3 older_e[OLDER];
#ifdef SCANOUT
uniform mat3 older_H_linear[OLDER], older_H_square[OLDER];
uniform vec3 older_e_linear[OLDER], older_e_square[OLDER];
#endif
uniform ivec2 rendered_size;
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

#ifdef TEXELS
layout(rgba16f) readonly uniform image2D older_colour[OLDER]; // takes llvmpipe half the time of fetches
vec4 colour_texel(int k, ivec2 texel) {
    return imageLoad(older_colour[k], texel);
}
#else
uniform sampler2D older_colour[OLDER];
vec4 colour_texel(int k, ivec2 texel) {
    return texelFetch(older_colour[k], texel, 0);
}
#endif

// Copies: llvmpipe checks the bounds of each load of a uniform, and hoists none out of the loop.
mat3 maps[OLDER];
vec3 parallax[OLDER];
ivec2 extent;
float tolerance, least;

void prepare_older() {
    for (int k = 0; k < OLDER; ++k) {
        maps[k] = older_H[k];
        parallax[k] = older_e[k];
    }
    extent = rendered_size;
    tolerance = depth_tolerance;
    least = depth_tolerance * depth_floor;
}

// The colour of frame k at p: parabolas through the nearest texel and those beside it, along its row and
// its column, no brighter or darker than the three nearest. Five loads: beside a newest frame that is
// sampled by lib/catmull_rom.glsl that is as good as its twelve. Alpha is 0 where one is not covered.
vec4 sampled(int k, vec2 p) {
    ivec2 n = ivec2(p), last = extent - 1;
    vec2 off = p - vec2(n) - 0.5, t = abs(off);
    ivec2 side = ivec2(off.x < 0.0 ? -1 : 1, off.y < 0.0 ? -1 : 1);
    ivec2 next = clamp(n + side, ivec2(0), last), before = clamp(n - side, ivec2(0), last);
    vec4 a = colour_texel(k, n), b = colour_texel(k, ivec2(next.x, n.y)), c = colour_texel(k, ivec2(n.x, next.y));
    vec4 d = colour_texel(k, ivec2(before.x, n.y)), e = colour_texel(k, ivec2(n.x, before.y));
    vec3 twice = 2.0 * a.rgb, slopes = t.x * (b.rgb - d.rgb) + t.y * (c.rgb - e.rgb);
    vec3 bends = t.x * t.x * (b.rgb + d.rgb - twice) + t.y * t.y * (c.rgb + e.rgb - twice);
    vec3 least = min(min(b.rgb, c.rgb), a.rgb), most = max(max(b.rgb, c.rgb), a.rgb);
    return vec4(clamp(a.rgb + 0.5 * (slopes + bends), least, most), min(min(min(b.a, c.a), min(d.a, e.a)), a.a));
}

// Alpha is 1 where frame k saw the surface at `depth` (1/m, below 0 for none) of a shown pixel, else 0.
vec4 looked_up(int k, vec2 shown, float depth) {
    vec3 at = vec3(shown, 1.0), q = maps[k] * at + parallax[k] * depth;
#ifdef SCANOUT
    float t = 1.0 - shown.y / float(shown_size.y);
    q += t * ((older_H_linear[k] + t * older_H_square[k]) * at + (older_e_linear[k] + t * older_e_square[k]) * depth);
#endif
    vec2 p = q.xy / q.z, from = vec2(extent);
    float expected = depth / q.z, held = imageLoad(older_inverse_depth[k], ivec2(floor(p))).r;
    vec4 colour = sampled(k, p);
    bool inside = q.z > 0.0 && p.x >= 0.0 && p.y >= 0.0 && p.x < from.x && p.y < from.y;
    bool saw = depth >= 0.0 && held >= 0.0 && abs(held - expected) <= tolerance * min(held, expected) + least;
    return inside && saw && colour.a > 0.0 ? vec4(colour.rgb, 1.0) : vec4(0.0);
}
