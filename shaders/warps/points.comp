// Projects points as discs that face along their normals; the nearest disc of each pixel wins.
// In: points in pages of 16, each of one cell. Out: colour and inverse depth; holes where no disc
// is, or the sky, infinitely far.
// Source: Zwicker et al. 2001, Surface Splatting (discs, rays met with their planes); keys as
// lib/depth_key.glsl; Hoff et al. 1999 (a depth that rises from the middle gives each pixel to
// the nearest middle).
//
// PASS 0 finds the nearest key of each pixel, PASS 1 the lowest point that has it, PASS 2 colours
// the pixel. An empty pixel beside a disc is a crack, and a hole; farther away it is sky.
#if PASS == 2
#include "lib/rows.glsl"
#else
layout(local_size_x = 64) in;
#endif
uniform ivec2 shown_size;
uniform vec2 lowest; // tangents of the left and lower edge
uniform vec2 pixels; // for each tangent
uniform int count;
uniform float size;
uniform float largest;

const uint NOBODY = 0xFFFFFFFFu;
const float NEAR_M = 0.02;
// How much farther a disc's edge counts than its middle, in radii.
const float RISE = 0.5;
const float STEPS = 1023.0;

layout(std430, binding = 0) buffer Keys { uint key_of[]; };
layout(std430, binding = 1) buffer Winners { uint winner_of[]; };
layout(std430, binding = 2) readonly buffer Points { uint point_of[]; };
layout(std430, binding = 3) readonly buffer Pages { uint cell_of[]; };
// Lowest corner and edge; radius, body, whether double-sided.
layout(std430, binding = 4) readonly buffer Cells { vec4 of_cell[]; };
layout(std430, binding = 5) readonly buffer Bodies { mat4 eye_from[]; };

struct Disc {
    bool drawn;
    vec3 middle; // in eye space
    vec3 normal;
    float radius;
};

vec3 normal_of(uint word) {
    vec2 f = vec2(word & 255u, (word >> 8) & 255u) / 127.0 - 1.0;
    vec3 n = vec3(f, 1.0 - abs(f.x) - abs(f.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return normalize(n);
}

Disc disc_of(uint index) {
    Disc disc = Disc(false, vec3(0.0), vec3(0.0, 0.0, 1.0), 0.0);
    uint cell = cell_of[index / 16u];
    if (cell == NOBODY) return disc;
    vec4 place = of_cell[2u * cell], more = of_cell[2u * cell + 1u];
    uint place_of = point_of[3u * index];
    vec3 steps = vec3(place_of & 1023u, (place_of >> 10) & 1023u, (place_of >> 20) & 1023u);
    mat4 eye = eye_from[uint(more.y)];
    disc.middle = (eye * vec4(place.xyz + steps * (place.w / STEPS), 1.0)).xyz;
    disc.normal = mat3(eye) * normal_of(point_of[3u * index + 1u]);
    disc.radius = size * more.x;
    float facing = -dot(disc.middle, disc.normal);
    // A disc seen along its plane, within the error of its normal, is drawn.
    disc.drawn = disc.middle.z < -NEAR_M && (more.z != 0.0 || facing > -0.02 * length(disc.middle));
    return disc;
}

// Inverse depth of the disc's plane on the ray through that pixel, and (y) the squared distance from
// the middle in radii; y above 1 beside the disc.
vec2 met(Disc disc, vec2 pixel) {
    vec3 ray = vec3(lowest + pixel / pixels, -1.0);
    float at = dot(disc.middle, disc.normal), along = dot(ray, disc.normal);
    float inverse_depth = along / at;
    if (!(inverse_depth > 0.0) || inverse_depth > 1.0 / NEAR_M) return vec2(0.0, 2.0);
    vec3 off = ray / inverse_depth - disc.middle;
    return vec2(inverse_depth, dot(off, off) / (disc.radius * disc.radius));
}

#if PASS < 2
#include "lib/depth_key.glsl"

void offer(ivec2 at, uint index, float inverse_depth) {
    uint slot = uint(at.y) * uint(shown_size.x) + uint(at.x);
    uint key = depth_key(inverse_depth, ivec2(index, index >> 2), index);
#if PASS == 0
    atomicMax(key_of[slot], key);
#else
    if (key_of[slot] == key) atomicMin(winner_of[slot], index);
#endif
}

void main() {
    uint index = gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * 64u) + gl_GlobalInvocationID.x;
    if (index >= uint(count)) return;
    Disc disc = disc_of(index);
    if (!disc.drawn) return;
    float depth = -disc.middle.z;
    vec2 centre = (disc.middle.xy / depth - lowest) * pixels;
    vec2 reach = min(disc.radius / depth * pixels * (1.0 + length(disc.middle.xy) / depth), vec2(largest));
    if (any(lessThan(centre + reach, vec2(0.0))) || any(greaterThan(centre - reach, vec2(shown_size)))) return;
    ivec2 own = ivec2(floor(centre));
    ivec2 first = max(ivec2(floor(centre - reach)), ivec2(0));
    ivec2 last = min(ivec2(floor(centre + reach)), shown_size - 1);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec2 found = met(disc, vec2(x, y) + 0.5);
            if (found.y <= 1.0)
                offer(ivec2(x, y), index, found.x * (1.0 - min(RISE * found.y * disc.radius * found.x, 0.5)));
            else if (ivec2(x, y) == own)
                offer(own, index, 1.0 / (depth + RISE * disc.radius));
        }
}
#else
layout(rgba16f) writeonly uniform image2D shown_colour;
#if WRITES_DEPTH
layout(r32f) writeonly uniform image2D shown_inverse_depth;
#endif
uniform vec3 zenith;
uniform vec3 horizon;
uniform vec3 ground;
uniform vec3 up; // the world's up in eye space
uniform int has_sky;
const int RIM = 2; // pixels

vec3 linear_of(uint word) {
    vec3 s = vec3(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u) / 255.0;
    return mix(s / 12.92, pow((s + 0.055) / 1.055, vec3(2.4)), greaterThan(s, vec3(0.04045)));
}

bool beside(ivec2 at) {
    ivec2 low = max(at - RIM, ivec2(0)), high = min(at + RIM, shown_size - 1);
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x)
            if (winner_of[uint(y) * uint(shown_size.x) + uint(x)] != NOBODY) return true;
    return false;
}

void resolve(ivec2 at) {
    uint slot = uint(at.y) * uint(shown_size.x) + uint(at.x);
    uint winner = winner_of[slot];
    vec4 colour = vec4(0.0);
    float inverse_depth = -1.0;
    if (winner != NOBODY) {
        Disc disc = disc_of(winner);
        vec2 found = met(disc, vec2(at) + 0.5);
        colour = vec4(linear_of(point_of[3u * winner + 2u]), 1.0);
        inverse_depth = found.y <= 1.0 ? found.x : -1.0 / disc.middle.z;
    } else if (has_sky != 0 && !beside(at)) {
        float high = dot(normalize(vec3(lowest + (vec2(at) + 0.5) / pixels, -1.0)), up);
        colour = vec4(mix(horizon, high > 0.0 ? zenith : ground, sqrt(abs(high))), 1.0);
        inverse_depth = 0.0;
    }
    imageStore(shown_colour, at, colour);
#if WRITES_DEPTH
    imageStore(shown_inverse_depth, at, vec4(inverse_depth));
#endif
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    for (int row = 0; row < ROWS; ++row)
        if (first.y + row < shown_size.y) resolve(first + ivec2(0, row));
}
#endif
