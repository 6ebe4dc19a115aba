// How much an older frame counts in each block of 8 x 8 pixels, and by how much light has changed.
// In: the sums of older_compare.comp. Out: for each frame and block the mean difference of the newest frame to the
// older (rgb) and the older one's weight (alpha).
// Source: this project's; the shift by least squares of Lucas and Kanade 1981.
layout(local_size_x = 64) in;
layout(rgba32f) readonly uniform image2D sums;
layout(rgba16f) writeonly uniform image2D told;
uniform ivec2 blocks; // columns and rows of them
uniform int frames;  // their sums, and what is told, lie one above the other

// Where light has changed by this much of a square root of luminance, the older frame counts for
// 0.6: a moving lamp's shadow that is taken for noise would smear.
const float LIGHT = 0.08;
// Pixels by which the older frame may lie off, for the same. The mean of three keeps 0.97 of the slope
// of a pattern of ten pixels at any shift; with 0.5 it keeps 0.92.
const float SHIFT = 0.35;
// Squared pixels by which all of the difference could be explained by a shift. Noise of one pixel
// explains 2, as central differences of it have half its variance in both directions; a shift that is
// too large for the least squares explains more. Of 64 samples the figure is off by a quarter; above
// that the older frame soon counts for nothing.
const float NOISE = 2.5;
// Of a squared gradient: flat places, which noise alone would seem to move, stay where they are.
const float LEAST_GRADIENT = 2e-4;

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (block.x >= blocks.x) return;
    int first = block.y / blocks.y * blocks.y;
    ivec2 next = ivec2(0, frames * blocks.y);
    vec4 differences = vec4(0.0), shifts = vec4(0.0), products = vec4(0.0);
    float squares = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            ivec2 at = block + ivec2(x, y);
            // The block itself counts twice as much as those beside it, on each axis.
            float weight = at.y < first || at.y >= first + blocks.y ? 0.0 : float((2 - abs(x)) * (2 - abs(y)));
            differences += weight * imageLoad(sums, at);
            shifts += weight * imageLoad(sums, at + next);
            squares += weight * imageLoad(sums, at + 3 * next).r;
            products += weight * imageLoad(sums, at + 2 * next);
        }
    float count = max(differences.a, 1e-3), light = shifts.x / count;
    vec2 moved = shifts.yz - vec2(shifts.w, products.w) * light;
    float xx = products.x + LEAST_GRADIENT * count, yy = products.z + LEAST_GRADIENT * count, xy = products.y;
    vec2 shift = vec2(yy * moved.x - xy * moved.y, xx * moved.y - xy * moved.x) / (xx * yy - xy * xy);
    float apart = (squares - count * light * light) / (xx + yy);
    // Luminance stands for three channels.
    float off = 3.0 * light * light / (LIGHT * LIGHT) + dot(shift, shift) / (SHIFT * SHIFT) + 4.0 * max(apart - NOISE, 0.0);
    imageStore(told, block, vec4(differences.rgb / count, exp(-0.5 * off)));
}
