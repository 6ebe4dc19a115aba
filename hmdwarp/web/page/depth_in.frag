// The rendered inverse depth as the warps read it, with fringes moved as warps/iterative_fringe.comp
// moves them: the pixel beside a nearer surface, whose colour antialiasing has mixed, goes with it.
// In: numbers; or (CODED) codes of a video and what kind each pixel is. Out: 1/m, -1 for none.
// Source: as warps/iterative_fringe.comp; for codes docs/feed.md, depth 4.
#ifdef CODED
uniform usampler2D codes, kinds;
uniform float code_step; // 1/m of a code
uniform float bend;      // codes from where on steps grow; 0 for never
#else
uniform sampler2D given;
#endif
uniform ivec2 rendered_size;
uniform float depth_tolerance;
uniform float depth_floor; // 1/m
out vec4 moved;

// -1 for what is no depth; 0 beyond the border, where an image reads 0.
float depth_at(ivec2 pixel) {
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, rendered_size))) return 0.0;
#ifdef CODED
    uint kind = texelFetch(kinds, pixel, 0).r;
    float code = float(texelFetch(codes, pixel, 0).r);
    code = code == 0.0 ? 0.25 : code;
    float found = code_step * (bend > 0.0 ? bend * (exp(code / bend) - 1.0) : code);
    return kind == 0u ? found : kind == 1u ? 0.0 : -1.0;
#else
    float found = texelFetch(given, pixel, 0).r;
    return found >= 0.0 && found < 1e30 ? found : -1.0;
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float own = depth_at(pixel);
    float across = max(depth_at(pixel - ivec2(1, 0)), depth_at(pixel + ivec2(1, 0)));
    float nearest = max(across, max(depth_at(pixel - ivec2(0, 1)), depth_at(pixel + ivec2(0, 1))));
    bool steps = own >= 0.0 && nearest - own > depth_tolerance * (own + depth_floor);
    moved = vec4(steps ? nearest : own);
}
