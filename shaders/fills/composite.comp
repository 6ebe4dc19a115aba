// An empty pixel gets the unlit colour of the client's own picture, times the mean (or median) of
// the light found at random places around it: the shown colour there, as it is. A place counts if
// it is covered, and depth and normal of the client's picture agree there. Places lie on the side
// from which the background came: of its move m by the warp, the foreground lies towards +m.
// In: shown colour; the client's unlit colour and its inverse depth; H, e shown -> rendered eye, in
// pixels of the shown picture. Out: colour and inverse depth; pixels that find no light stay empty.
// Source: algorithm 3 of the 2014 thesis this project starts from; O'Neill 2014, PCG (the hash).
#define ROWS 4 // of a piece
#include "lib/hole_columns.glsl"
#include "lib/coverage.glsl"
#include "lib/warp_map.glsl"
#include "lib/model_normal.glsl"
layout(rgba16f) readonly uniform image2D warped;
layout(rgba16f) readonly uniform image2D unlit;
layout(rgba16f) writeonly uniform image2D filled;
layout(r32f) writeonly uniform image2D filled_depth;
layout(std430, binding = 2) readonly buffer Offsets { ivec2 offset_of[]; }; // a power of two of them
uniform int samples;
uniform uint frame_seed;
uniform float same_depth; // relative difference up to which two depths agree
uniform float same_way;   // least cosine between two normals that agree

const float LEAST_MOVE = 0.5;   // pixels: below it no side is the background's
const float LARGEST = 65504.0;  // of a half float
#if MEDIAN
#define MOST MEDIAN
#include "lib/insertion_median.glsl"
#endif

uint mixed(uint number) {
    uint state = number * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// How far the background of a pixel has moved from where it was rendered, 0 if that is nowhere.
vec2 move_of(vec2 here, float depth) {
    vec3 was = H * vec3(here, 1.0) + e * depth;
    vec2 move = was.z > 0.0 ? here - was.xy / was.z : vec2(0.0);
    return dot(move, move) >= LEAST_MOVE * LEAST_MOVE ? move : vec2(0.0);
}

vec3 normal_of(ivec2 p, float depth) {
    return normal_at(vec2(p) + 0.5, depth, slope_at(p, depth));
}

void visit(ivec2 p) {
    float depth = imageLoad(model_inverse_depth, p).r;
    vec3 normal = normal_of(p, depth), sum = vec3(0.0);
    vec2 move = move_of(vec2(p) + 0.5, depth);
    uint start = mixed(uint(p.x) + mixed(uint(p.y) + mixed(frame_seed)));
    float count = 0.0;
    for (int k = 0; k < samples; ++k) {
        ivec2 offset = offset_of[mixed(start + uint(k)) % uint(offset_of.length())];
        ivec2 place = p + (dot(vec2(offset), move) > 0.0 ? -offset : offset);
        bool inside = all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, shown_size));
        vec4 light = imageLoad(warped, place);
        float its = imageLoad(model_inverse_depth, place).r;
        bool agrees = abs(its - depth) <= same_depth * (min(its, depth) + FLOOR);
        agrees = agrees && inside && light.a > HIDDEN && dot(normal_of(place, its), normal) >= same_way;
#if MEDIAN
        if (agrees) insert(light.rgb);
#else
        sum += agrees ? light.rgb : vec3(0.0);
#endif
        count += agrees ? 1.0 : 0.0;
    }
    if (count == 0.0) return;
#if MEDIAN
    vec3 average = middle_of_sorted();
    sorted_count = 0;
#else
    vec3 average = sum / count;
#endif
    imageStore(filled, p, vec4(min(imageLoad(unlit, p).rgb * average, vec3(LARGEST)), 1.0));
    imageStore(filled_depth, p, vec4(depth));
}

void main() {
    ivec2 p = first_of_column();
    if (p.x >= shown_size.x) return;
    uint left = 0u;
    for (int row = 0; row < ROWS; ++row) left |= p.y + row < shown_size.y && imageLoad(warped, p + ivec2(0, row)).a == 0.0 ? 1u << row : 0u;
    if (left == 0u) return;
    do visit(p + ivec2(0, findLSB(left))); while ((left &= left - 1u) != 0u);
}
