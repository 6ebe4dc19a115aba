// Compare the shown picture with what an older frame shows there, in blocks of 8 x 8 pixels.
// In: both. Out: sums over every second pixel of each block, on each axis.
// Source: this project's; gradients for the shift by least squares of Lucas and Kanade 1981, An
// Iterative Image Registration Technique.
layout(local_size_x = 64) in;
layout(rgba16f) readonly uniform image2D shown_colour;
layout(rgba16f) readonly uniform image2D looked_up;
// Four pictures with a pixel for each block, one above the other: difference (rgb) and count; then of
// square roots of luminance: difference, its product with the gradient (x, y), gradient along x;
// products of gradients (xx, xy, yy), gradient along y; squared difference.
layout(rgba32f) writeonly uniform image2D sums;
uniform ivec2 blocks; // columns and rows of them

const int SIDE = 8;

// Square roots are about as even to the eye as display values are, and cheaper. Alpha stays.
vec2 lightness(vec4 colour) {
    return vec2(sqrt(max(dot(colour.rgb, vec3(0.25, 0.5, 0.25)), 0.0)), colour.a);
}

vec2 lightness_at(ivec2 pixel) {
    return lightness(imageLoad(shown_colour, pixel));
}

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (block.x >= blocks.x) return;
    vec4 differences = vec4(0.0), shifts = vec4(0.0), products = vec4(0.0);
    float squares = 0.0;
    for (int k = 0; k < SIDE * SIDE / 4; ++k) {
        ivec2 pixel = block * SIDE + 2 * ivec2(k % (SIDE / 2), k / (SIDE / 2));
        vec4 newest = imageLoad(shown_colour, pixel), older = imageLoad(looked_up, pixel);
        vec2 left = lightness_at(pixel - ivec2(1, 0)), right = lightness_at(pixel + ivec2(1, 0));
        vec2 below = lightness_at(pixel - ivec2(0, 1)), above = lightness_at(pixel + ivec2(0, 1));
        float difference = lightness(newest).x - lightness(older).x;
        bool whole = min(min(above.y, below.y), min(left.y, right.y)) > 0.0;
        vec2 slope = whole ? 0.5 * vec2(right.x - left.x, above.x - below.x) : vec2(0.0);
        float saw = older.a * newest.a;
        differences += saw * vec4(newest.rgb - older.rgb, 1.0);
        shifts += saw * vec4(difference, slope * difference, slope.x);
        squares += saw * difference * difference;
        products += saw * vec4(slope.x * slope, slope.y * slope.y, slope.y);
    }
    imageStore(sums, block, differences);
    imageStore(sums, block + ivec2(0, blocks.y), shifts);
    imageStore(sums, block + ivec2(0, 2 * blocks.y), products);
    imageStore(sums, block + ivec2(0, 3 * blocks.y), vec4(squares));
}
