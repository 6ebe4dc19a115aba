// The change of a picture's error from the picture before it, in the same direction of view.
// In: both pairs, rgba8 sRGB, the reference's rows, with alpha where nothing is seen, and then the
// other's. Out: the mean over the channels, 0 to 1; -1 where the picture before does not reach.
// Source: this project's, see PairPass.
#define ROWS 4
layout(local_size_x = 64, local_size_y = 1) in;
layout(rgba8ui, binding = 0) readonly uniform uimage2D pixels;
layout(rgba8ui, binding = 2) readonly uniform uimage2D pixels_before;
layout(r32f, binding = 3) writeonly uniform image2D map;
uniform ivec2 size; // of one picture
uniform mat3 before_from_now; // pixels, the top row first

const float ROUNDING = 1e-3; // of a place in float32, in pixels: those on the border stay inside

vec3 error_now(ivec2 p) {
    return vec3(imageLoad(pixels, p + ivec2(0, size.y)).rgb) - vec3(imageLoad(pixels, p).rgb);
}

vec3 error_before(ivec2 p) {
    return vec3(imageLoad(pixels_before, p + ivec2(0, size.y)).rgb) - vec3(imageLoad(pixels_before, p).rgb);
}

void main() {
    ivec2 q = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
    if (q.x >= size.x || q.y >= size.y) return;
    for (int n = 0; n < ROWS; ++n, ++q.y) {
        if (q.y >= size.y) break;
        vec3 there = before_from_now * vec3(vec2(q) + 0.5, 1.0);
        vec2 place = there.xy / there.z - 0.5, last = vec2(size - 1);
        bool is_inside = there.z > 0.0 && all(greaterThan(place, vec2(-ROUNDING))) && all(lessThan(place, last + ROUNDING));
        place = clamp(place, vec2(0.0), last);
        uint hidden = imageLoad(pixels, q).a | imageLoad(pixels_before, ivec2(place + 0.5)).a;
        ivec2 a = ivec2(place), d = min(a + 1, size - 1);
        vec2 share = place - vec2(a);
        vec3 upper = mix(error_before(a), error_before(ivec2(d.x, a.y)), share.x);
        vec3 lower = mix(error_before(ivec2(a.x, d.y)), error_before(d), share.x);
        vec3 change = abs(error_now(q) - mix(upper, lower, share.y));
        imageStore(map, q, vec4(is_inside && hidden == 0u ? (change.r + change.g + change.b) / 765.0 : -1.0));
    }
}
