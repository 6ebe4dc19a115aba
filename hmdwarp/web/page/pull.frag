// A level of the pyramid from the one below: of each 2 x 2 texels those of what lies behind, as a
// hole shows what was hidden.
// In, out: colour times its weight, weight; inverse depth.
// Source: Gortler et al. 1996, The Lumigraph (pull and push); the choice of what lies behind as in
// fills/pyramid_pull.comp.
uniform sampler2D colours, depths;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 depth;

const float SAME = 1.5, FLOOR = 0.02; // of the farthest inverse depth, and 1/m
const float NEARER = 0.02;            // the weight of what is nearer

void main() {
    ivec2 low = 2 * ivec2(gl_FragCoord.xy), last = textureSize(colours, 0) - 1;
    vec4 found[4];
    float at[4];
    float farthest = 1e30;
    for (int k = 0; k < 4; ++k) {
        ivec2 texel = min(low + ivec2(k & 1, k >> 1), last);
        found[k] = texelFetch(colours, texel, 0);
        at[k] = max(texelFetch(depths, texel, 0).r, 0.0);
        farthest = found[k].a > 0.25 ? min(farthest, at[k]) : farthest;
    }
    colour = vec4(0.0);
    float weighted = 0.0;
    for (int k = 0; k < 4; ++k) {
        float counts = at[k] <= SAME * farthest + FLOOR ? 1.0 : NEARER;
        colour += counts * found[k];
        weighted += counts * found[k].a * at[k];
    }
    depth = vec4(colour.a > 0.0 ? weighted / colour.a : -1.0);
    colour /= max(colour.a, 1.0);
}
