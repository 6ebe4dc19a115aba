// Gathers each shown pixel from the late picture through the client's own depth; a depth test keeps what was hidden empty.
// In: shown pixel and the client's inverse depth there. Out: rendered pixel by H, e (here shown -> rendered) and what it held.
// Source: the reverse of McMillan and Bishop's map; depth test as in shadow mapping (Williams 1978), per texel of the footprint.
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
layout(rgba16f) writeonly uniform image2D shown_colour;
uniform ivec2 shown_size;
uniform sampler2D late_inverse_depth;
uniform sampler2D client_inverse_depth;
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

// Where to look so that only texels whose depth agrees are averaged: the point itself if all four do, else the centre of
// the agreeing texel that weighs most (the texel order is that of textureGather). None agrees: agree is false.
vec2 where_depth_agrees(vec2 p, float inverse_depth, out bool agree) {
    vec2 corner = floor(p - 0.5) + 0.5;
    // Gathered at the meeting point of the four texels: at p itself rounding could pick another four.
    vec4 held = textureGather(late_inverse_depth, (corner + 0.5) * late_pixel);
    vec4 same = vec4(lessThanEqual(abs(held - inverse_depth), vec4(depth_tolerance * (inverse_depth + depth_floor))));
    vec2 w = p - corner;
    vec4 weight = same * (vec4(1.0 - w.x, w.x, w.x, 1.0 - w.x) * vec4(w.y, w.y, 1.0 - w.y, 1.0 - w.y) + 1e-6);
    float best = max(max(weight.x, weight.y), max(weight.z, weight.w));
    vec2 at = weight.w == best ? vec2(0.0) : weight.z == best ? vec2(1.0, 0.0) : weight.x == best ? vec2(0.0, 1.0) : vec2(1.0);
    agree = best > 0.0;
    return same == vec4(1.0) ? p : corner + at;
}

vec4 gathered(ivec2 shown, vec3 base) {
    float own = texelFetch(client_inverse_depth, shown, 0).r;
    vec3 q = base + e * own;
    vec2 p = q.xy / q.z;
    bool agree;
    vec2 at = where_depth_agrees(p, own / q.z, agree);
    vec4 colour = covered_average(at);
    return own >= 0.0 && q.z > 0.0 && inside(p, late_size) && agree ? colour : vec4(0.0);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= shown_size.y) break;
        ivec2 shown = first + ivec2(0, row);
        imageStore(shown_colour, shown, gathered(shown, base + H[1] * float(row)));
    }
}
