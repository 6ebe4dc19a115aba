// The grid of a picture that is coarser beyond a sharp rectangle: which pixels of the picture one of
// the coarser picture holds. All in pixels, from the bottom left; see geometry/fovea.py.
uniform ivec2 picture_size, small_size; // of the picture, and of the coarser one
uniform ivec2 sharp_from, sharp;        // the sharp rectangle's first pixel, and its size
uniform ivec2 before;                   // columns of the rim left of it, rows below
uniform int rim;                        // pixels on each axis that one of the rim holds
uniform float of_rim;                   // 1 / rim: a division of integers takes llvmpipe longer than all else

// Two inverse depths of one surface: a plane changes by 3 % a pixel at most (client/warps/
// gather.py), and one of the rim holds a few. What differs by more is never averaged.
const float ONE_SURFACE = 0.1, DEPTH_FLOOR = 0.02;

bool one_surface(float a, float b) {
    return abs(a - b) <= ONE_SURFACE * (max(a, b) + DEPTH_FLOOR);
}

// Of a pixel of the coarser picture: the first one that it holds, and how many on each axis.
ivec2 first_of(ivec2 own) {
    ivec2 at = own - before;
    return min(own, before) * rim + clamp(at, ivec2(0), sharp) + max(at - sharp, ivec2(0)) * rim;
}

ivec2 count_of(ivec2 own) {
    ivec2 at = own - before;
    return ivec2(at.x >= 0 && at.x < sharp.x ? 1 : rim, at.y >= 0 && at.y < sharp.y ? 1 : rim);
}
