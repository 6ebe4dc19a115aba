// Run `panel_pixel` for every pixel of the panel that shows part of the shown field of view; the
// others are black. A colour channel samples axis + scale * radius in the shown view, in pixels;
// scales: the lens's magnification of red, green and blue there. With LENS_TANGENTS the lens gives
// each channel a tangent of its own, and from_axis is that in pixels of the shown picture.
//
// A lens leaves up to two fifths of its panel unused. llvmpipe repeats a loop's body as long as one
// of eight neighbouring pixels needs it, so the loop runs from the first used row to the last, and
// eight unused neighbours cost one row of ROWS.
layout(rgba16f) writeonly uniform image2D written;
uniform ivec2 panel_size;
uniform ivec2 shown_size;
// Copies made before the loop, see lib/gather.glsl.
vec4 lens_placing;
vec2 shown_extent, per_tangent;
vec2 axis; // where the lens's axis meets the shown picture, in its pixels

void prepare_pixels();
#ifdef LENS_TANGENTS
vec4 panel_pixel(ivec2 p, mat3x2 from_axis);
#else
vec4 panel_pixel(ivec2 p, vec2 radius, vec3 scales);
#endif

bool in_view(vec2 shown) {
    return shown.x >= 0.0 && shown.y >= 0.0 && shown.x < shown_extent.x && shown.y < shown_extent.y;
}

vec2 on_lens_at(int x, int y) {
    return (vec2(x, y) + 0.5) * lens_placing.xy + lens_placing.zw;
}

#ifdef LENS_TANGENTS
mat3x2 from_axis_at(vec2 on_lens) {
    mat3x2 tangents = lens_tangents(on_lens);
    return mat3x2(tangents[0] * per_tangent, tangents[1] * per_tangent, tangents[2] * per_tangent);
}

bool sees_any(vec2 on_lens) {
    mat3x2 from_axis = from_axis_at(on_lens);
    return in_view(axis + from_axis[0]) || in_view(axis + from_axis[1]) || in_view(axis + from_axis[2]);
}
#else
bool sees_any(vec2 on_lens) {
    vec3 scales = lens_scales(on_lens);
    vec2 radius = on_lens * per_tangent;
    return in_view(axis + scales.r * radius) || in_view(axis + scales.g * radius) || in_view(axis + scales.b * radius);
}
#endif

void main() {
    ivec2 first = first_pixel(), size = panel_size;
    if (first.x >= size.x) return;
    lens_placing = lens_from_panel;
    shown_extent = vec2(shown_size);
    per_tangent = shown_from_tangent.xy * shown_extent;
    axis = shown_from_tangent.zw * shown_extent;
    prepare_lens();
    prepare_pixels();
    int begin = 0, end = min(ROWS, size.y - first.y), rows = end;
    while (begin < end && !sees_any(on_lens_at(first.x, first.y + begin))) ++begin;
    while (begin < end && !sees_any(on_lens_at(first.x, first.y + end - 1))) --end;
    for (int row = 0; row < begin; ++row) imageStore(written, first + ivec2(0, row), vec4(0.0));
    for (int row = end; row < rows; ++row) imageStore(written, first + ivec2(0, row), vec4(0.0));
    for (int row = begin; row < end; ++row) {
        ivec2 p = first + ivec2(0, row);
        vec2 on_lens = on_lens_at(p.x, p.y);
#ifdef LENS_TANGENTS
        imageStore(written, p, panel_pixel(p, from_axis_at(on_lens)));
#else
        imageStore(written, p, panel_pixel(p, on_lens * per_tangent, lens_scales(on_lens)));
#endif
    }
}
