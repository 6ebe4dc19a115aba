// How far a cell's two triangles may lie from the finer ones they replace, in shown pixels.
// Errors are kept as inverse depth, which does not depend on where the point is; what is allowed
// depends on the motion.
#include "lib/warp_map.glsl"
const float INFINITE = 1e30; // an error that is never allowed
uniform float tolerance;     // shown pixels; 0 merges what is exactly flat
uniform float reach;         // shown pixels by which 1/m moves a point at equal depths, the most in the picture
uniform int coarsest;        // cells on a side of the largest cell

// The largest distance between a cell and the same cell in four, at the five points that the four
// add; 3x3 points, row by row. The triangles nest (all have the diagonal from the lower right to
// the upper left), so it is nowhere larger than there, and the errors of all levels add up to a
// bound on the whole.
float unevenness(float r00, float r10, float r20, float r01, float r11, float r21, float r02, float r12, float r22) {
    float along_x = max(abs(2.0 * r10 - r00 - r20), abs(2.0 * r12 - r02 - r22));
    float along_y = max(abs(2.0 * r01 - r00 - r02), abs(2.0 * r21 - r20 - r22));
    return 0.5 * max(max(along_x, along_y), abs(2.0 * r11 - r20 - r02));
}

// 1/m: a point that is off by d 1/m lands off by reach * d / w shown pixels; w is linear over a
// cell, so least at a corner.
float allowed_error(ivec2 pixel, int side, float r00, float r10, float r01, float r11) {
    vec3 w = vec3(H[0].z, H[1].z, H[2].z);
    float first = dot(w, vec3(vec2(pixel) + 0.5, 1.0));
    vec2 across = w.xy * float(side);
    float lower = min(first + e.z * r00, first + across.x + e.z * r10);
    float least = min(lower, min(first + across.y + e.z * r01, first + across.x + across.y + e.z * r11));
    // Without motion any error is allowed but the infinite one.
    return min(tolerance * max(least, 0.0) / max(reach, 1e-30), 0.5 * INFINITE);
}
