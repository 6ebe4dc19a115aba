// The grid of a picture that is coarser beyond a sharp rectangle: which pixels of the picture one of
// the coarser picture holds. All in pixels, from the bottom left; see geometry/fovea.py.
uniform ivec2 picture_size;
uniform ivec2 sharp_from, sharp; // the sharp rectangle's first pixel, and its size
uniform int rim;                 // pixels on each axis that one of the rim holds

// Two inverse depths of one surface: a plane changes by 3 % a pixel at most (client/warp_kinds/
// gather.py), and one of the rim holds a few. What differs by more is never averaged.
const float ONE_SURFACE = 0.1, DEPTH_FLOOR = 0.02;

bool one_surface(float a, float b) {
    return abs(a - b) <= ONE_SURFACE * (max(a, b) + DEPTH_FLOOR);
}

ivec2 small_size() {
    return sharp + (picture_size - sharp) / rim;
}

// Of a pixel of the coarser picture: the first one that it holds, and how many on each axis.
ivec2 first_of(ivec2 own) {
    ivec2 before = sharp_from / rim, beyond = own - before - sharp;
    ivec2 inside = sharp_from + min(own - before, sharp);
    return ivec2(
        own.x < before.x ? own.x * rim : inside.x + max(beyond.x, 0) * rim,
        own.y < before.y ? own.y * rim : inside.y + max(beyond.y, 0) * rim
    );
}

ivec2 count_of(ivec2 own) {
    ivec2 at = own - sharp_from / rim;
    return ivec2(at.x >= 0 && at.x < sharp.x ? 1 : rim, at.y >= 0 && at.y < sharp.y ? 1 : rim);
}

// The pixel of the coarser picture that holds a pixel.
ivec2 holder_of(ivec2 p) {
    ivec2 before = sharp_from / rim, beyond = max(p - sharp_from - sharp, ivec2(0)) / rim;
    ivec2 inside = before + min(p - sharp_from, sharp) + beyond;
    return ivec2(p.x < sharp_from.x ? p.x / rim : inside.x, p.y < sharp_from.y ? p.y / rim : inside.y);
}
