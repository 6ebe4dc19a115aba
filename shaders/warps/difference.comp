// The client's own picture of a simplified scene, plus what the late picture had more than it.
// In: the simplified scene for the shown view (WARPED) and for the rendered one, the difference.
// Out: the sum, in display space, as linear light. WARPED: the difference is looked up through the
// shown depth, where the simplified scene shows the same surface in both views; elsewhere it is 0.
// Source: Levoy 1995 (without WARPED); Williams 1978 (the depth test).
#include "lib/rows.glsl"
#include "lib/display_bytes.glsl"
layout(rgba16f) readonly uniform image2D difference;
#if WARPED
layout(rgba16f) readonly uniform image2D shown_model;
layout(r32f) readonly uniform image2D shown_model_depth;
uniform float depth_tolerance, depth_floor;
#else
layout(rgba16f) readonly uniform image2D rendered_model;
uniform bool whole_pixels;
#endif
layout(r32f) readonly uniform image2D rendered_model_depth;
layout(rgba16f) writeonly uniform image2D written;
#ifdef WRITES_DEPTH
layout(r32f) writeonly uniform image2D shown_inverse_depth;
#endif
uniform ivec2 shown_size, rendered_size;
uniform mat3 H;
#if WARPED
uniform vec3 e;
#endif

bool inside(ivec2 p) {
    return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, rendered_size));
}

// In bytes; a codec's values lie between the 511 levels.
vec3 difference_at(ivec2 p) {
    return encoded_of(imageLoad(difference, p).rgb) * 510.0 - 255.0;
}

vec3 light_of_sum(vec3 bytes) {
    return light_of(clamp(bytes, 0.0, 255.0) / 255.0);
}

#if WARPED
vec4 sum_at(ivec2 shown, out float inverse_depth) {
    inverse_depth = imageLoad(shown_model_depth, shown).r;
    vec3 model = bytes_of(imageLoad(shown_model, shown).rgb);
    vec3 q = H * vec3(vec2(shown) + 0.5, 1.0) + e * inverse_depth;
    if (q.z <= 0.0) return vec4(light_of_sum(model), 1.0);
    float expected = inverse_depth / q.z;
    vec2 place = q.xy / q.z - 0.5;
    ivec2 first = ivec2(floor(place));
    vec2 part = place - floor(place);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 step = ivec2(k & 1, k >> 1), at = first + step;
        if (!inside(at)) continue;
        float held = imageLoad(rendered_model_depth, at).r;
        if (abs(held - expected) > depth_tolerance * (expected + depth_floor)) continue;
        vec2 share = mix(1.0 - part, part, vec2(step));
        sum += vec4(difference_at(at), 1.0) * (share.x * share.y);
    }
    return vec4(light_of_sum(model + (sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0))), 1.0);
}
#else
vec3 late_at(ivec2 p) {
    return clamp(bytes_of(imageLoad(rendered_model, p).rgb) + difference_at(p), 0.0, 255.0);
}

vec4 sum_at(ivec2 shown, out float inverse_depth) {
    vec3 q = H * vec3(vec2(shown) + 0.5, 1.0);
    vec2 place = q.xy / q.z - 0.5;
    ivec2 nearest = ivec2(floor(place + 0.5));
    inverse_depth = -1.0;
    if (!inside(nearest)) return vec4(0.0);
    inverse_depth = imageLoad(rendered_model_depth, nearest).r;
    if (whole_pixels) return vec4(light_of_sum(round(late_at(nearest))), 1.0);
    ivec2 first = ivec2(floor(place));
    vec2 part = place - floor(place);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 step = ivec2(k & 1, k >> 1), at = first + step;
        if (!inside(at)) continue;
        vec2 share = mix(1.0 - part, part, vec2(step));
        sum += vec4(light_of_sum(late_at(at)), 1.0) * (share.x * share.y);
    }
    return vec4(sum.rgb / sum.a, 1.0);
}
#endif

void main() {
    ivec2 p = first_pixel();
    if (p.x >= shown_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= shown_size.y) break;
        float inverse_depth;
        imageStore(written, p, sum_at(p, inverse_depth));
#ifdef WRITES_DEPTH
        imageStore(shown_inverse_depth, p, vec4(inverse_depth, 0.0, 0.0, 0.0));
#endif
    }
}
