// The depth of the shown picture in the form that runtimes take: reversed, 1 at the near plane, 0
// infinitely far.
// In: inverse depth in 1/m, -1 where unknown. Out: depth 0..1; unknown depth becomes infinitely
// far.
// Source: Reed 2015, Depth Precision Visualized (reversed z with an infinite far plane: d = near /
// z).
uniform sampler2D inverse_depth;
uniform vec2 texel_from_pixel; // texels a pixel of the framebuffer
uniform float near_m;

void main() {
    float nearness = texelFetch(inverse_depth, ivec2(gl_FragCoord.xy * texel_from_pixel), 0).r;
    gl_FragDepth = isnan(nearness) ? 0.0 : clamp(near_m * nearness, 0.0, 1.0);
}
