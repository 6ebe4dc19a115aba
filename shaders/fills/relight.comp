// Holes get the model's albedo times the light of blocks that are near in space, lie in their plane
// and face their way; without any, the model's own light. In: where the holes are; the model's
// albedo, inverse depth and, in the holes, lit colour; a Light of each block. Out: colour in the
// holes.
// Source: this project's, after Tomasi and Manduchi 1998, Bilateral Filtering (weights by distance
// and similarity).
layout(local_size_x = 64) in;
uniform ivec2 shown_size;
#include "lib/relight.glsl"
layout(rgba16f) readonly uniform image2D albedo;
layout(rgba32f) readonly uniform image2D lights;
layout(rgba16f) uniform image2D filled; // with the model's lit colour in the holes on entry
layout(std430, binding = 1) readonly buffer Samples { ivec4 sample_of[]; }; // xy: offset in pixels
layout(std430, binding = 2) readonly buffer Holes { uint hole_count, none_a, none_b, none_c; uint hole_at[]; };
uniform int samples;
uniform float near;           // distance, relative to the distance from the eye, at which the weight is a quarter
uniform float off_plane;      // and off the surface's plane, at which it is a half
uniform float model_weight;   // weight of the model's own light, relative to as much albedo seen close by

const float LARGEST = 65504.0; // of a half float

// Colour of a hole's pixel: the quotient of sums, not the sum of quotients, because an albedo near
// black says little about the light.
vec3 relit(ivec2 p, vec3 lit) {
    float depth = imageLoad(model_inverse_depth, p).r;
    vec2 here = vec2(p) + 0.5;
    vec3 point = point_at(here, depth), normal = normal_at(here, depth, slope_at(p, depth));
    vec3 seen = vec3(0.0), plain = vec3(0.0);
    for (int k = 0; k < samples; ++k) {
        ivec2 place = p + sample_of[k].xy;
        bool inside = all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, shown_size));
        ivec2 light = inside ? place / BLOCK * ivec2(PARTS, 1) : ivec2(0);
        vec4 block_seen = imageLoad(lights, light), block_plain = imageLoad(lights, light + ivec2(1, 0));
        vec4 block_point = imageLoad(lights, light + ivec2(2, 0));
        vec3 way = (block_point.xyz - point) * (depth + FLOOR);
        float nearness = 1.0 / (1.0 + dot(way, way) / (near * near)), off = dot(way, normal) / off_plane;
        float facing = max(dot(normal, vec3(block_seen.a, block_plain.a, block_point.a)), 0.0);
        facing *= facing;
        float weight = inside ? nearness * nearness * facing * facing / (1.0 + off * off) : 0.0;
        seen += weight * block_seen.rgb;
        plain += weight * block_plain.rgb;
    }
    return (imageLoad(albedo, p).rgb * seen + model_weight * lit) / (plain + model_weight);
}

void main() {
    uint k = gl_GlobalInvocationID.x;
    if (k >= hole_count) return;
    for (; k < hole_count; k += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        ivec2 p = ivec2(hole_at[k] & 0xffffu, hole_at[k] >> 16);
        imageStore(filled, p, vec4(min(relit(p, imageLoad(filled, p).rgb), vec3(LARGEST)), 1.0));
    }
}
