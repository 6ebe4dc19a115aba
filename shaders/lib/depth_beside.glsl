// The shown inverse depth of a sample, for warps whose place does not depend on depth: that of the
// rendered pixels around it, each seen from the shown eye, averaged as the sampler averages colours.
// Source: McMillan and Bishop 1995 (the third row of the map is the ratio of both depths);
// docs/conventions.md.
#ifdef WRITES_DEPTH
layout(r32f) readonly uniform image2D rendered_inverse_depth;
uniform vec4 depth_ratio; // rendered over shown depth: of a pixel (x, y), 1 and its inverse depth

vec2 share_of(ivec2 texel, float share) {
    ivec2 p = clamp(texel, ivec2(0), ivec2(rendered_extent) - 1);
    float rendered = imageLoad(rendered_inverse_depth, p).r;
    float ratio = dot(depth_ratio, vec4(vec2(p) + 0.5, 1.0, rendered));
    bool known = rendered >= 0.0 && rendered < 1e30 && ratio > 0.0;
    return known ? share * vec2(rendered / ratio, 1.0) : vec2(0.0);
}

float shown_depth_of(vec2 p) {
    vec2 at = clamp(p, vec2(0.0), rendered_extent) - 0.5, low = floor(at), upper = at - low, lower = 1.0 - upper;
    ivec2 texel = ivec2(low);
    vec2 sum = share_of(texel, lower.x * lower.y) + share_of(texel + ivec2(1, 0), upper.x * lower.y)
             + share_of(texel + ivec2(0, 1), lower.x * upper.y) + share_of(texel + ivec2(1, 1), upper.x * upper.y);
    return sum.y >= 0.5 ? sum.x / sum.y : -1.0;
}
#endif
