// Shared by the passes of fill `relight`: the light of the shown picture in blocks of BLOCK x BLOCK
// pixels. Of each block only the farthest surface counts, so that none is lit by surfaces in front
// of it. A surface is a plane of inverse depth.
#include "lib/model_normal.glsl"
const int BLOCK = 8;

// Three texels a block, side by side. rgb of the first: shown colour, the mean over all pixels of
// the block, 0 for those that do not count; of the second: the model's colour, likewise (its
// albedo, or albedo times baked light); of the third: the surface's position, in metres along the
// eye's axes. The three alphas together: its normal, of length 1. An image, because llvmpipe loads
// its texels whole and a buffer's numbers one by one: half the time.
const int PARTS = 3;

vec3 point_at(vec2 p, float depth) {
    return vec3(tangent_start + p * tangent_step, -1.0) / (depth + FLOOR);
}
