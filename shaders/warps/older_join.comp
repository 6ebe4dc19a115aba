// Average the shown picture with what older frames saw of the same surfaces: of each its detail
// alone, so that light is always the newest frame's.
// In: the shown picture; what older_look.comp and older_agree.comp found. Out: the shown picture.
// Source: this project's.
#define ROWS 8
#include "lib/rows.glsl"
layout(rgba16f) uniform image2D shown_colour;
layout(rgba16f) readonly uniform image2D looked_up[OLDER];
layout(rgba16f) readonly uniform image2D told[OLDER]; // of each block
uniform ivec2 shown_size;
uniform ivec2 last_block;

// A column of blocks as it is at a pixel's column.
vec4 across(int k, int y, ivec2 columns, float share) {
    int row = clamp(y, 0, last_block.y);
    return mix(imageLoad(told[k], ivec2(columns.x, row)), imageLoad(told[k], ivec2(columns.y, row)), share);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    // Between the centres of blocks: the column's rows lie between three of them.
    float place = (float(first.x) + 0.5) / float(ROWS) - 0.5, left = floor(place);
    ivec2 columns = clamp(ivec2(left) + ivec2(0, 1), ivec2(0), last_block.xx);
    int block = first.y / ROWS;
    vec4 below[OLDER], middle[OLDER], above[OLDER];
    for (int k = 0; k < OLDER; ++k) {
        below[k] = across(k, block - 1, columns, place - left);
        middle[k] = across(k, block, columns, place - left);
        above[k] = across(k, block + 1, columns, place - left);
    }
    for (int row = 0; row < ROWS; ++row) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.y >= shown_size.y) break;
        vec4 newest = imageLoad(shown_colour, pixel), sum = vec4(newest.rgb, 1.0);
        float share = (float(row) + 0.5) / float(ROWS) - 0.5;
        for (int k = 0; k < OLDER; ++k) {
            vec4 older = imageLoad(looked_up[k], pixel);
            vec4 agreed = mix(middle[k], share < 0.0 ? below[k] : above[k], abs(share));
            float weight = older.a * agreed.a;
            sum += weight * vec4(older.rgb + agreed.rgb, 1.0);
        }
        imageStore(shown_colour, pixel, newest.a > 0.0 ? vec4(max(sum.rgb / sum.a, 0.0), newest.a) : vec4(0.0));
    }
}
