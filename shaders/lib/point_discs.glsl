// Points as discs that face along their normals, and where a pixel's ray meets one.
// In: points in pages of 16, each of one cell.
// Source: Zwicker et al. 2001, Surface Splatting (rays met with the planes of discs); Cigolle et al.
// 2014 (octahedral normals).
#include "lib/octahedral.glsl"
uniform ivec2 shown_size;
uniform vec2 lowest; // tangents of the left and lower edge
uniform vec2 pixels; // for each tangent
uniform float size;

const uint NOBODY = 0xFFFFFFFFu;
const float NEAR_M = 0.02;
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
