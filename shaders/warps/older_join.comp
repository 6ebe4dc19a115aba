// Average the shown picture with what older frames saw of the same surfaces: of each its detail
// alone, so that light is always the newest frame's.
// In: the shown picture and its inverse depth; older frames, and what older_agree.comp found of them.
// Out: the shown picture.
// Source: this project's.
layout(local_size_x = 32) in;
layout(rgba16f) uniform image2D shown_colour;
layout(rgba16f) readonly uniform image2D told; // of each block, the older frames one above the other
uniform ivec2 blocks; // columns and rows of them
uniform ivec2 shown_size;
#include "lib/older.glsl"

const int SIDE = 8;

// A row of blocks as it is at a pixel's row.
vec4 across(int k, int x, ivec2 rows, float share, ivec2 count) {
    int column = clamp(x, 0, count.x - 1);
    return mix(imageLoad(told, ivec2(column, k * count.y + rows.x)), imageLoad(told, ivec2(column, k * count.y + rows.y)), share);
}

void main() {
    ivec2 first = ivec2(gl_GlobalInvocationID.xy) * ivec2(SIDE, 1), size = shown_size, count = blocks;
    if (first.x >= size.x) return;
    prepare_older();
    // Between the centres of blocks: the row's columns lie between three of them.
    float place = (float(first.y) + 0.5) / float(SIDE) - 0.5, low = floor(place);
    ivec2 rows = clamp(ivec2(low) + ivec2(0, 1), ivec2(0), count.yy - 1);
    int block = first.x / SIDE;
    vec4 before[OLDER], middle[OLDER], after[OLDER];
    for (int k = 0; k < OLDER; ++k) {
        before[k] = across(k, block - 1, rows, place - low, count);
        middle[k] = across(k, block, rows, place - low, count);
        after[k] = across(k, block + 1, rows, place - low, count);
    }
    for (int column = 0; column < SIDE; ++column) {
        ivec2 pixel = first + ivec2(column, 0);
        if (pixel.x >= size.x) break;
        vec4 newest = imageLoad(shown_colour, pixel), sum = vec4(newest.rgb, 1.0);
        float depth = imageLoad(shown_inverse_depth, pixel).r; // -1 in holes
        float share = (float(column) + 0.5) / float(SIDE) - 0.5;
        for (int k = 0; k < OLDER; ++k) {
            vec4 older = looked_up(k, vec2(pixel) + 0.5, depth);
            vec4 agreed = mix(middle[k], share < 0.0 ? before[k] : after[k], abs(share));
            sum += older.a * agreed.a * vec4(older.rgb + agreed.rgb, 1.0);
        }
        imageStore(shown_colour, pixel, newest.a > 0.0 ? vec4(max(sum.rgb / sum.a, 0.0), newest.a) : vec4(0.0));
    }
}
