// Run a gather warp's `gathered` for every pixel of the shown view. The function named by PREPARE,
// if a warp defines it, is called once before the loop over rows.
// shown: the pixel's centre. base + parallax * inverse_depth: the rendered pixel (homogeneous) of a
// point at that depth from here.
#include "lib/rows.glsl"
#include "lib/gather.glsl"
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 shown_size;
#ifdef WRITES_DEPTH
// Receives found_inverse_depth of `gathered`, -1 in holes
layout(r32f) writeonly uniform image2D shown_inverse_depth;
float found_inverse_depth;
#endif
vec4 gathered(vec2 shown, vec3 base, vec3 parallax);

// The value of base at the centre of the shown pixel that contains `shown`: here that is `shown`
// itself.
vec3 base_at_centre(vec2 shown, vec3 base) {
    return base;
}

void main() {
    ivec2 first = first_pixel(), size = shown_size;
    if (first.x >= size.x) return;
    prepare_sampling();
#ifdef PREPARE
    PREPARE();
#endif
    vec2 start = vec2(first) + 0.5;
    vec3 base = H * vec3(start, 1.0), up = H[1], parallax = e;
#ifdef SCANOUT
    float row_share = 1.0 / float(size.y);
    vec3 base_linear = H_linear * vec3(start, 1.0), base_square = H_square * vec3(start, 1.0);
    vec3 up_linear = H_linear[1], up_square = H_square[1], first_e = e, linear_e = e_linear, square_e = e_square;
#endif
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= size.y) break;
        vec2 shown = start + vec2(0.0, float(row));
        vec3 here = base + up * float(row);
#ifdef SCANOUT
        float t = 1.0 - shown.y * row_share;
        here += t * (base_linear + up_linear * float(row) + t * (base_square + up_square * float(row)));
        parallax = first_e + t * (linear_e + t * square_e);
#endif
        vec4 found = gathered(shown, here, parallax);
        imageStore(written, first + ivec2(0, row), found);
#ifdef WRITES_DEPTH
        imageStore(shown_inverse_depth, first + ivec2(0, row), vec4(found.a > 0.0 ? found_inverse_depth : -1.0));
#endif
    }
}
