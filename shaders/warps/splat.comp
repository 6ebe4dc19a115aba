// Every rendered pixel covers the parallelogram that its square becomes; the nearest depth wins,
// and colours are fetched back through it.
// In: rendered pixel and inverse depth. Out: shown colour; coverage 0 where no footprint of a
// rendered pixel reaches.
// Source: Westover 1990 (footprints); Zwicker et al. 2001, EWA Splatting (the footprint is the
// derivative of the map); Mori et al. 2009 (depth warped forward, colour fetched backward).
//
// PASS 0: the map of the square around each rendered pixel, on the plane through its neighbours'
// depths, is a small homography; each shown pixel whose centre it covers keeps the nearest inverse
// depth by atomicMax. PASS 1 takes each shown pixel back to the rendered picture through that depth
// and averages the rendered pixels of that surface by the area that the shown pixel covers of each.
// The shown pixel alone fixes the order of every sum, so two runs are identical, and light of any
// size and sign can be averaged.
#include "lib/scatter_sizes.glsl"
#include "lib/warp_map.glsl"
layout(r32f) readonly uniform image2D rendered_inverse_depth;
// 0 = nothing landed, else 1 + the bits of the nearest shown inverse depth
layout(std430, binding = 0) buffer Keys { uint key_of[]; };
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

const float LARGEST = 3.402823466e38; // the largest finite float32

bool known(float inverse_depth) {
    return inverse_depth >= 0.0 && inverse_depth <= LARGEST;
}

float rendered_at(ivec2 rendered) {
    // Beyond the border an image reads 0, which would pass for sky.
    float held = imageLoad(rendered_inverse_depth, rendered).r;
    return all(lessThan(uvec2(rendered), uvec2(rendered_size))) ? held : -1.0;
}

#if PASS == 0
uniform float reach;   // pixels: the largest extent of a footprint from its middle
uniform float overlap; // pixels of the rendered picture by which squares are enlarged on each side
const float SMALLEST = 1.17549435e-38; // the smallest normal float32
const float NEAREST = 1048576.0; // 1/m: nothing nearer than a micrometre to the eye is drawn

// The step of inverse depth to the next pixel, from those on both sides: surfaces are connected
// where the step is small relative to the depth, or where the motion opens it by less than a pixel.
// With the next depth `change` more this pixel would land change * parallax / (1 + change *
// receding) beside.
float slope(float before, float here, float after, float parallax, float receding) {
    float down = before - here, up = after - here;
    float most = depth_tolerance * (here + depth_floor);
    bool has_down = known(before) && (abs(down) <= most || abs(down) * parallax <= 1.0 + down * receding);
    bool has_up = known(after) && (abs(up) <= most || abs(up) * parallax <= 1.0 + up * receding);
    return has_down ? (has_up ? 0.5 * (up - down) : -down) : (has_up ? up : 0.0);
}

void cover(ivec2 rendered, vec3 base, float below, float here, float above) {
    vec3 q = base + e * here;
    if (!known(here) || !(q.z > 0.0)) return;
    vec2 p = q.xy / q.z;
    if (!all(lessThan(abs(p), vec2(1e9)))) return; // NaN would make the bounds below all of the picture
    vec2 moves = abs(e.xy - p * e.z) / q.z;
    float parallax = max(moves.x, moves.y), receding = e.z / q.z;
    vec2 step = vec2(slope(rendered_at(rendered - ivec2(1, 0)), here, rendered_at(rendered + ivec2(1, 0)), parallax, receding),
                     slope(below, here, above, parallax, receding));
    // Within its square a patch keeps half its inverse depth or more: else it would tip over beyond
    // infinity.
    step *= here / max(max(abs(step.x) + abs(step.y), here), SMALLEST);
    // A point d rendered pixels beside lands at p + J d / (1 + a d), J = (across, along), with w =
    // q.z (1 + a d). So what lands `off` beside p is, with u = J^-1 off, at d = u / (1 - a u),
    // where 1 + a d = 1 / (1 - a u): its inverse depth is affine in `off`.
    vec3 qx = H[0] + e * step.x, qy = H[1] + e * step.y;
    vec2 across = (qx.xy - p * qx.z) / q.z, along = (qy.xy - p * qy.z) / q.z;
    vec2 a = vec2(qx.z, qy.z) / q.z;
    float half_side = 0.5 + overlap;
    float least = 1.0 - half_side * (abs(a.x) + abs(a.y));
    vec2 extent = least > 0.0 ? min(half_side * (abs(across) + abs(along)) / least, vec2(reach)) : vec2(reach);
    vec2 low = max(ceil(p - extent - 0.5), vec2(0.0)), high = min(floor(p + extent - 0.5), vec2(shown_size - 1));
    mat2 inverse_J = mat2(along.y, -across.y, -along.x, across.x) / (across.x * along.y - along.x * across.y);
    vec2 per_u = step - here * a;
    for (float y = low.y; y <= high.y; y += 1.0) {
        for (float x = low.x; x <= high.x; x += 1.0) {
            vec2 u = inverse_J * (vec2(x, y) + 0.5 - p);
            float before = 1.0 - dot(a, u); // > 0 in front of the eye
            float nearness = abs(max(here + dot(per_u, u), 0.0) / q.z); // abs: -0 is 0
            if (max(abs(u.x), abs(u.y)) <= half_side * before && before > 0.0 && nearness <= NEAREST)
                atomicMax(key_of[int(y) * shown_size.x + int(x)], floatBitsToUint(nearness) + 1u);
        }
    }
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= rendered_size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    float below = rendered_at(first - ivec2(0, 1)), here = rendered_at(first);
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= rendered_size.y) break;
        float above = rendered_at(first + ivec2(0, row + 1));
        cover(first + ivec2(0, row), base + H[1] * float(row), below, here, above);
        below = here;
        here = above;
    }
}
#else
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(rgba16f) writeonly uniform image2D shown_colour;
const float WIDEST = 3.0; // rendered pixels on each axis that a shown one is averaged over, at most
const float SHARPNESS = 0.6667; // up to 1.5 rendered pixels a shown one four are enough, as for any bilinear sample

// The difference of a rendered pixel's inverse depth from the expected one.
float off(ivec2 rendered, float expected) {
    float held = rendered_at(rendered);
    return known(held) ? abs(held - expected) : LARGEST;
}

// Of the pixels under the box of these sides around p, those whose depth is off by at most `most`,
// weighted by the area under the box.
vec4 average_over(vec2 p, vec2 sides, float expected, float most) {
    vec2 low = p - 0.5 * sides, high = p + 0.5 * sides;
    ivec2 from = ivec2(floor(max(low, vec2(0.0)))), to = ivec2(ceil(min(high, vec2(rendered_size)))) - 1;
    vec4 sum = vec4(0.0);
    for (int y = from.y; y <= to.y; ++y) {
        float height = min(high.y, float(y + 1)) - max(low.y, float(y));
        for (int x = from.x; x <= to.x; ++x) {
            float area = height * (min(high.x, float(x + 1)) - max(low.x, float(x)));
            float held = imageLoad(rendered_inverse_depth, ivec2(x, y)).r;
            if (abs(held - expected) <= most) sum += area * imageLoad(rendered_colour, ivec2(x, y));
        }
    }
    return sum;
}

// Four pixels are what a box of one pixel covers. At least the best match counts: on a steep
// surface none may be within the tolerance.
vec4 average(vec2 p, vec2 sides, float expected, float most) {
    ivec2 corner = ivec2(floor(p - 0.5));
    vec2 upper = p - 0.5 - vec2(corner), lower = 1.0 - upper;
    vec4 area = vec4(lower.x, upper.x, lower.x, upper.x) * vec4(lower.yy, upper.yy);
    vec4 far = vec4(off(corner, expected), off(corner + ivec2(1, 0), expected), off(corner + ivec2(0, 1), expected),
                    off(corner + ivec2(1, 1), expected));
    far = mix(vec4(LARGEST), far, greaterThan(area, vec4(0.0)));
    most = max(most, min(min(far.x, far.y), min(far.z, far.w)));
    if (any(greaterThan(sides, vec2(1.0)))) return average_over(p, clamp(sides, vec2(1.0), vec2(WIDEST)), expected, most);
    area = mix(vec4(0.0), area, lessThanEqual(far, vec4(most)));
    vec4 sum = area.x * imageLoad(rendered_colour, corner);
    sum += area.y * imageLoad(rendered_colour, corner + ivec2(1, 0));
    sum += area.z * imageLoad(rendered_colour, corner + ivec2(0, 1));
    return sum + area.w * imageLoad(rendered_colour, corner + ivec2(1, 1));
}

#ifdef WRITES_DEPTH
layout(r32f) writeonly uniform image2D shown_inverse_depth;
#endif

// base + e * inverse_depth: the rendered pixel (homogeneous) of a point at that inverse depth in
// the shown view. Here H, e: shown -> rendered.
vec4 fetched(uint key, vec3 base) {
    float nearness = uintBitsToFloat(key - 1u);
    vec3 q = base + e * nearness;
    if (key == 0u || !(q.z > 0.0)) return vec4(0.0);
    // Rounding may put it slightly outside; clamped well beyond that, so that no input makes the
    // loops long.
    vec2 p = clamp(q.xy / q.z, vec2(-1.0), vec2(rendered_size + 1));
    float expected = nearness / q.z;
    vec2 across = (H[0].xy - p * H[0].z) / q.z, along = (H[1].xy - p * H[1].z) / q.z;
    vec2 sides = SHARPNESS * sqrt(across * across + along * along);
    float most = depth_tolerance * (expected + depth_floor);
    vec4 sum = average(p, sides, expected, most);
    return sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    for (int row = 0; row < ROWS; ++row) {
        ivec2 shown = first + ivec2(0, row);
        if (shown.y >= shown_size.y) break;
        int slot = shown.y * shown_size.x + shown.x;
        uint key = key_of[slot];
        key_of[slot] = 0u;
        vec4 colour = fetched(key, base + H[1] * float(row));
        imageStore(shown_colour, shown, colour);
#ifdef WRITES_DEPTH
        imageStore(shown_inverse_depth, shown, vec4(colour.a > 0.0 ? uintBitsToFloat(key - 1u) : -1.0));
#endif
    }
}
#endif
