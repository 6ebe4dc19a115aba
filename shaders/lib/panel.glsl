// Runs `panel_pixel` for every pixel of the panel that sees anything of the shown field of view; the others are black.
// A colour looks at axis + scale * radius in the shown view, in pixels; scales: how much the lens magnifies red, green and blue there.
//
// A lens leaves up to two fifths of its panel blind. llvmpipe repeats a loop's body as long as one of eight neighbouring pixels wants
// it, so the loop runs from the first row that sees to the last, and eight blind neighbours cost one row of ROWS.
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 panel_size;
uniform ivec2 shown_size;
vec2 axis;         // where the lens's axis meets the shown picture, in its pixels
vec2 shown_extent; // a copy made before the loop, see lib/gather.glsl

void prepare_pixels();
vec4 panel_pixel(ivec2 p, vec2 radius, vec3 scales);

bool in_view(vec2 shown) {
    return shown.x >= 0.0 && shown.y >= 0.0 && shown.x < shown_extent.x && shown.y < shown_extent.y;
}

void main() {
    ivec2 first = first_pixel(), size = panel_size;
    if (first.x >= size.x) return;
    vec4 lens = lens_from_panel, pixels = shown_from_tangent * vec4(shown_size, shown_size);
    axis = pixels.zw;
    shown_extent = vec2(shown_size);
    prepare_lens();
    prepare_pixels();
    int rows = min(ROWS, size.y - first.y), begin = rows, end = 0;
    for (int row = 0; row < ROWS; ++row) {
        vec2 on_lens = (vec2(first + ivec2(0, row)) + 0.5) * lens.xy + lens.zw, radius = on_lens * pixels.xy;
        vec3 scales = lens_scales(on_lens);
        bool sees = in_view(axis + scales.r * radius) || in_view(axis + scales.g * radius) || in_view(axis + scales.b * radius);
        sees = sees && row < rows;
        begin = sees ? min(begin, row) : begin;
        end = sees ? row + 1 : end;
    }
    for (int row = 0; row < begin; ++row) imageStore(written, first + ivec2(0, row), vec4(0.0));
    for (int row = max(begin, end); row < rows; ++row) imageStore(written, first + ivec2(0, row), vec4(0.0));
    for (int row = begin; row < end; ++row) {
        ivec2 p = first + ivec2(0, row);
        vec2 on_lens = (vec2(p) + 0.5) * lens.xy + lens.zw;
        imageStore(written, p, panel_pixel(p, on_lens * pixels.xy, lens_scales(on_lens)));
    }
}
