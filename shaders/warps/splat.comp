// Every drawn pixel covers the parallelogram that its square becomes; the nearest depth stays, colours are fetched back through it.
// In: rendered pixel and inverse depth. Out: shown colour; coverage 0 where no footprint of a drawn pixel reaches.
// Source: Westover 1990 (footprints); Zwicker et al. 2001, EWA Splatting (the footprint is the derivative of the map); Mori et al. 2009
// (depth warped forward, colour fetched backward).
//
// PASS 0: the square around each drawn pixel, on the plane that its neighbours' depths give, is a small homography; each shown pixel
// whose centre it covers keeps the nearest inverse depth by atomicMax. PASS 1 takes each shown pixel back to the late picture
// through that depth and averages the drawn pixels of that surface by the area that the shown pixel covers of each.
// Every sum has its order fixed by the shown pixel alone, so two runs are equal, and light of any size and sign can be averaged.
#include "lib/scatter_sizes.glsl"
#include "lib/warp_map.glsl"
layout(r32f) readonly uniform image2D late_inverse_depth;
layout(std430, binding = 0) buffer Keys { uint key_of[]; }; // 0 = nothing landed, else 1 + the bits of the nearest shown inverse depth
uniform float depth_tolerance;
uniform float depth_floor; // 1/m, the part of the tolerance that does not shrink with distance

const float LARGEST = 3.402823466e38; // the largest finite float32

bool known(float inverse_depth) {
    return inverse_depth >= 0.0 && inverse_depth <= LARGEST;
}

#if PASS == 0
uniform float reach;   // pixels: how far a footprint may go from its middle
uniform float overlap; // pixels of the late picture by which squares are larger on each side
const float NEAREST = 1048576.0; // 1/m: what comes nearer than a micrometre to the eye is not drawn

// The step of inverse depth to the next pixel, from those on both sides: surfaces hang together where the step is small against the
// depth, or where the motion opens it by less than a pixel (opening: pixels per 1/m).
float slope(float before, float here, float after, float opening) {
    float down = here - before, up = after - here;
    float most = depth_tolerance * (here + depth_floor);
    bool has_down = known(before) && (abs(down) <= most || abs(down) * opening <= 1.0);
    bool has_up = known(after) && (abs(up) <= most || abs(up) * opening <= 1.0);
    return has_down ? (has_up ? 0.5 * (down + up) : down) : (has_up ? up : 0.0);
}

float late_at(ivec2 drawn) {
    // Beyond the border an image reads 0, which would pass for sky.
    float held = imageLoad(late_inverse_depth, drawn).r;
    return all(lessThan(uvec2(drawn), uvec2(late_size))) ? held : -1.0;
}

void cover(ivec2 drawn, vec3 base) {
    float here = imageLoad(late_inverse_depth, drawn).r;
    vec3 q = base + e * here;
    if (!known(here) || !(q.z > 0.0)) return;
    vec2 p = q.xy / q.z;
    vec2 parallax = (e.xy - p * e.z) / q.z;
    float opening = max(abs(parallax.x), abs(parallax.y));
    vec2 step = vec2(slope(late_at(drawn - ivec2(1, 0)), here, late_at(drawn + ivec2(1, 0)), opening),
                     slope(late_at(drawn - ivec2(0, 1)), here, late_at(drawn + ivec2(0, 1)), opening));
    // A point d late pixels beside lands at p + J d / (1 + a d), J = (across, along), at w = q.z (1 + a d).
    vec3 qx = H[0] + e * step.x, qy = H[1] + e * step.y;
    vec2 across = (qx.xy - p * qx.z) / q.z, along = (qy.xy - p * qy.z) / q.z;
    vec2 a = vec2(qx.z, qy.z) / q.z;
    float half_side = 0.5 + overlap;
    float least = 1.0 - half_side * (abs(a.x) + abs(a.y));
    vec2 extent = least > 0.0 ? min(half_side * (abs(across) + abs(along)) / least, vec2(reach)) : vec2(reach);
    vec2 low = max(ceil(p - extent - 0.5), vec2(0.0)), high = min(floor(p + extent - 0.5), vec2(shown_size - 1));
    for (float y = low.y; y <= high.y; y += 1.0) {
        for (float x = low.x; x <= high.x; x += 1.0) {
            vec2 off = vec2(x, y) + 0.5 - p;
            vec2 m0 = across - off * a.x, m1 = along - off * a.y; // (J - off a^T) d = off
            float det = m0.x * m1.y - m1.x * m0.y;
            vec2 d = vec2(off.x * m1.y - m1.x * off.y, m0.x * off.y - off.x * m0.y) / det;
            float w = q.z * (1.0 + dot(a, d));
            float nearness = abs(max(here + dot(step, d), 0.0) / w); // abs: -0 is 0
            if (max(abs(d.x), abs(d.y)) <= half_side && w > 0.0 && nearness <= NEAREST)
                atomicMax(key_of[int(y) * shown_size.x + int(x)], floatBitsToUint(nearness) + 1u);
        }
    }
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= late_size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    for (int row = 0; row < ROWS; ++row) {
        if (first.y + row >= late_size.y) break;
        cover(first + ivec2(0, row), base + H[1] * float(row));
    }
}
#else
layout(rgba16f) readonly uniform image2D late_colour;
layout(rgba16f) writeonly uniform image2D shown_colour;
const float WIDEST = 3.0; // late pixels that a shown one is averaged over, on each axis

// base + e * inverse_depth: the late pixel (homogeneous) of a point at that inverse depth in the shown view. Here H, e: shown -> rendered.
vec4 fetched(uint key, vec3 base) {
    float nearness = uintBitsToFloat(key - 1u);
    vec3 q = base + e * nearness;
    if (key == 0u || !(q.z > 0.0)) return vec4(0.0);
    // Rounding may put it a little outside; clamped well beyond that, so that no place makes the loops long.
    vec2 p = clamp(q.xy / q.z, vec2(-1.0), vec2(late_size + 1));
    float expected = nearness / q.z;
    vec2 across = (H[0].xy - p * H[0].z) / q.z, along = (H[1].xy - p * H[1].z) / q.z;
    vec2 half_size = 0.5 * clamp(sqrt(across * across + along * along), vec2(1.0), vec2(WIDEST));
    vec2 low = p - half_size, high = p + half_size;
    ivec2 from = ivec2(floor(max(low, vec2(0.0)))), to = ivec2(ceil(min(high, vec2(late_size)))) - 1;
    // First how well the best drawn pixel agrees: on a steep surface none may be within the tolerance.
    float best = LARGEST;
    for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x) {
            float held = imageLoad(late_inverse_depth, ivec2(x, y)).r;
            best = min(best, known(held) ? abs(held - expected) : LARGEST);
        }
    float most = max(best, depth_tolerance * (expected + depth_floor));
    vec4 sum = vec4(0.0);
    float area = 0.0;
    for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x) {
            vec2 side = min(high, vec2(x + 1, y + 1)) - max(low, vec2(x, y));
            float weight = side.x * side.y;
            float held = imageLoad(late_inverse_depth, ivec2(x, y)).r;
            if (known(held) && abs(held - expected) <= most && weight > 0.0) {
                sum += weight * imageLoad(late_colour, ivec2(x, y));
                area += weight;
            }
        }
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
        imageStore(shown_colour, shown, fetched(key, base + H[1] * float(row)));
    }
}
#endif
