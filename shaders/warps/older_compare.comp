// Compare the shown picture with what older frames show there, in blocks of 8 x 8 pixels.
// In: the shown picture and its inverse depth, older frames. Out: for each of them sums over every
// second pixel of each block, on each axis.
// Source: this project's; gradients for the shift by least squares of Lucas and Kanade 1981, An
// Iterative Image Registration Technique.
layout(local_size_x = 64) in;
layout(rgba16f) readonly uniform image2D shown_colour;
// Four pictures with a pixel for each block, one above the other: difference (rgb) and count; then of
// square roots of luminance: difference, its product with the gradient (x, y), gradient along x;
// products of gradients (xx, xy, yy), gradient along y; squared difference. Each is as many pictures
// as there are older frames.
layout(rgba32f) writeonly uniform image2D sums;
uniform ivec2 blocks; // columns and rows of them
uniform ivec2 shown_size;
#include "lib/older.glsl"

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
    prepare_older();
    vec4 differences[OLDER], shifts[OLDER], products[OLDER];
    float squares[OLDER];
    for (int k = 0; k < OLDER; ++k) {
        differences[k] = shifts[k] = products[k] = vec4(0.0);
        squares[k] = 0.0;
    }
    for (int sample_number = 0; sample_number < SIDE * SIDE / 4; ++sample_number) {
        ivec2 pixel = block * SIDE + 2 * ivec2(sample_number % (SIDE / 2), sample_number / (SIDE / 2));
        vec4 newest = imageLoad(shown_colour, pixel);
        vec2 left = lightness_at(pixel - ivec2(1, 0)), right = lightness_at(pixel + ivec2(1, 0));
        vec2 below = lightness_at(pixel - ivec2(0, 1)), above = lightness_at(pixel + ivec2(0, 1));
        bool whole = min(min(above.y, below.y), min(left.y, right.y)) > 0.0;
        vec2 slope = whole ? 0.5 * vec2(right.x - left.x, above.x - below.x) : vec2(0.0);
        float depth = imageLoad(shown_inverse_depth, pixel).r;
        for (int k = 0; k < OLDER; ++k) {
            vec4 older = looked_up(k, vec2(pixel) + 0.5, depth);
            float saw = older.a * newest.a, difference = lightness(newest).x - lightness(older).x;
            differences[k] += saw * vec4(newest.rgb - older.rgb, 1.0);
            shifts[k] += saw * vec4(difference, slope * difference, slope.x);
            squares[k] += saw * difference * difference;
            products[k] += saw * vec4(slope.x * slope, slope.y * slope.y, slope.y);
        }
    }
    for (int k = 0; k < OLDER; ++k) {
        ivec2 at = block + ivec2(0, k * blocks.y), next = ivec2(0, OLDER * blocks.y);
        imageStore(sums, at, differences[k]);
        imageStore(sums, at + next, shifts[k]);
        imageStore(sums, at + 2 * next, products[k]);
        imageStore(sums, at + 3 * next, vec4(squares[k]));
    }
}
