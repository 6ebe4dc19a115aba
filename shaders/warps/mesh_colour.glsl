// The rendered colour on the surface, and the surface's shown inverse depth for the depth test:
// both kinds of triangles, those of whole cells and (PIECES) of cut ones. VERTEX: sheets are cut
// here, by the connectedness test of Mark 1999, 3.3, per shown pixel.
#include "lib/warp_map.glsl"
uniform sampler2D rendered_colour;
uniform vec2 rendered_pixel;
in vec4 surface_point;
#if PIECES
flat in vec4 owner;
#endif
layout(location = 0) out vec4 colour;

// Depth order as in lib/scatter.glsl, in the 24 bits of the depth buffer: a float with 19 bits of
// its significand from 1000 km to 0.5 mm.
const uint NEAREST_BITS = 0x44FFFFFFu;
const uint FARTHEST_BITS = 0x35800000u;

float ordered(float inverse_depth) {
    uint bits = clamp(floatBitsToUint(max(inverse_depth, 0.0)), FARTHEST_BITS, NEAREST_BITS) - FARTHEST_BITS;
    return float((bits >> 4u) + 1u) / 16777215.0;
}

#if VERTEX
layout(r32f) readonly uniform image2D rendered_inverse_depth;
uniform ivec2 rendered_size;
uniform vec2 steepest;
uniform mat3 rendered_from_shown;
uniform vec3 rendered_parallax;

// A sheet between two surfaces is detected at its nearest vertex, which has another depth. Of each
// surface half a pixel around the vertex stays, in the vertex's own colour: the part at the
// vertex's own depth. False for the rest of the sheet.
bool keeps(inout vec2 at) {
    ivec2 pixel = clamp(ivec2(surface_point.xy), ivec2(0), rendered_size - 1);
    float own = imageLoad(rendered_inverse_depth, pixel).r;
    vec2 centre = vec2(pixel) + 0.5;
    float allowed = dot(steepest, abs(surface_point.xy - centre)) * min(own, surface_point.z);
    if (abs(surface_point.z - own) <= allowed) return true;
    at = centre;
    vec3 base = rendered_from_shown * vec3(gl_FragCoord.xy, 1.0);
    // Along this ray the rendered inverse depth `own` is met at base + rendered_parallax * s with s
    // = own base_z / (1 - own rendered_parallax_z).
    vec3 q = base * (1.0 - own * rendered_parallax.z) + rendered_parallax * (own * base.z);
    vec2 away = abs(q.xy / q.z - centre);
    return max(away.x, away.y) <= 0.5;
}
#endif

void main() {
    vec2 at = surface_point.xy;
#if PIECES
    vec2 away = owner.zw * max((surface_point.xy - owner.xy) * owner.zw, 0.0);
    // Joined both ways, and yet not whole: the corner across is another surface, which a bilinear
    // sample would include.
    at = owner.xy + (abs(away.x) > abs(away.y) ? vec2(away.x, 0.0) : vec2(0.0, away.y));
#endif
#if VERTEX
    bool kept = keeps(at);
#else
    const bool kept = true;
#endif
    vec4 sum = textureLod(rendered_colour, at * rendered_pixel, 0.0);
    // A missing surface has depth 0, which is behind everything and never drawn; a discard would
    // take llvmpipe longer.
    bool there = kept && sum.a >= 0.5;
#if ADAPTIVE
    float counts_for = surface_point.w; // large cells are held back behind small ones
#else
    const float counts_for = 1.0;
#endif
    gl_FragDepth = there ? ordered(surface_point.z * gl_FragCoord.w * counts_for) : 0.0;
    colour = vec4(sum.rgb / sum.a, 1.0);
}
