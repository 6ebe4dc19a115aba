// Put what deforms into the shown picture, in the light of the late one: of the same place of the
// surface if the late picture shows it, else of places of it that were near and faced the same way,
// else the baked light.
// In: the shown picture; what deforms now, without light, with its baked light, and where each place
// of it was then; the late picture, what deformed then without light, and the light on its blocks.
// Out: colour; inverse depth of what deforms is put into the shown picture's.
// Source: Nehab et al. 2007, Accelerating Real-Time Shading with Reverse Reprojection Caching (the
// same place); shaders/fills/relight.comp (places near it).
layout(local_size_x = 8, local_size_y = 8) in;
uniform ivec2 shown_size, late_size;
#include "lib/relight.glsl"
uniform sampler2D picture;
uniform sampler2D albedo, body_inverse_depth, lit, late_place, late_normal;
uniform sampler2D late_colour, late_inverse_depth, late_albedo, late_body_inverse_depth;
uniform sampler2D lights;
layout(r32f) uniform image2D shown_inverse_depth;
layout(rgba16f) writeonly uniform image2D written;
layout(std430, binding = 1) readonly buffer Samples { ivec4 sample_of[]; }; // xy: offset in pixels
uniform vec2 late_first, late_pixel; // tangents of the late picture's corner, of one pixel
uniform float same;                  // relative difference up to which two inverse depths are one surface
uniform float steepest;              // and of neighbouring pixels of one surface
uniform int samples;
uniform float near, off_plane, model_weight; // as in relight.comp

const float LARGEST = 65504.0; // of a half float
const float NEAREST = 0.02;    // metres
const float LEAST = 0.01;      // weight of late pixels below which the place counts as not seen
const float BLACK = 1e-4;      // an albedo that says nothing about the light

// Whether the late picture shows what deforms there, at about that inverse depth.
bool shows(ivec2 q, float r) {
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, late_size))) return false;
    float body = texelFetch(late_body_inverse_depth, q, 0).r;
    bool own = body >= 0.0 && texelFetch(late_inverse_depth, q, 0).r <= body * (1.0 + same);
    return own && abs(body - r) <= steepest * r;
}

vec3 colour_at(ivec2 p, vec3 own) {
    vec3 place = texelFetch(late_place, p, 0).xyz, away = texelFetch(late_normal, p, 0).xyz;
    vec3 baked = texelFetch(lit, p, 0).rgb;
    if (place.z > -NEAREST) return baked;
    float r = -1.0 / place.z;
    vec2 at = (place.xy * r - late_first) / late_pixel - 0.5;
    if (any(greaterThan(abs(at), vec2(1e6)))) return baked; // far beyond the picture: no such pixel
    ivec2 low = ivec2(floor(at));
    vec2 share = at - vec2(low);
    vec3 seen = vec3(0.0), plain = vec3(0.0);
    float sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 step = ivec2(k & 1, k >> 1);
        vec2 weights = mix(1.0 - share, share, vec2(step));
        float weight = dot(away, place) > 0.0 && shows(low + step, r) ? weights.x * weights.y : 0.0;
        if (weight <= 0.0) continue;
        seen += weight * texelFetch(late_colour, low + step, 0).rgb;
        plain += weight * texelFetch(late_albedo, low + step, 0).rgb;
        sum += weight;
    }
    if (sum >= LEAST) return (own * seen + BLACK * sum * baked) / (plain + BLACK * sum);
    seen = plain = vec3(0.0);
    vec3 point = place * (r / (r + FLOOR));
    ivec2 middle = ivec2(floor(at + 0.5));
    for (int k = 0; k < samples; ++k) {
        ivec2 q = middle + sample_of[k].xy;
        if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, late_size))) continue;
        ivec2 block = q / BLOCK * ivec2(PARTS, 1);
        vec4 one = texelFetch(lights, block, 0), two = texelFetch(lights, block + ivec2(1, 0), 0);
        vec4 three = texelFetch(lights, block + ivec2(2, 0), 0);
        vec3 way = (three.xyz - point) * (r + FLOOR);
        float nearness = 1.0 / (1.0 + dot(way, way) / (near * near)), off = dot(way, away) / off_plane;
        float facing = max(dot(away, vec3(one.a, two.a, three.a)), 0.0);
        facing *= facing;
        float weight = nearness * nearness * facing * facing / (1.0 + off * off);
        seen += weight * one.rgb;
        plain += weight * two.rgb;
    }
    return (own * seen + model_weight * baked) / (plain + model_weight);
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= shown_size.x || p.y >= shown_size.y) return;
    vec4 colour = texelFetch(picture, p, 0), own = texelFetch(albedo, p, 0);
    float r = texelFetch(body_inverse_depth, p, 0).r;
    if (own.a > 0.0 && imageLoad(shown_inverse_depth, p).r <= r * (1.0 + same)) {
        colour = vec4(clamp(colour_at(p, own.rgb), vec3(0.0), vec3(LARGEST)), 1.0);
        imageStore(shown_inverse_depth, p, vec4(r));
    }
    imageStore(written, p, colour);
}
