// The cheaper mirror: march each mirrored ray through the rendered picture itself. Rays that leave
// the picture are holes.
// In: the picture and its inverse depth. Out: the reflection in one plane mirror, rgba16f; the
// inverse depth of the whole path, -1 for none.
// Source: McGuire and Mara 2014, Efficient GPU Screen-Space Ray Tracing (JCGT 3:4): steps of equal
// length on the screen.
#define ROWS 4
#include "lib/rows.glsl"
#include "lib/mirrors.glsl"
layout(rgba16f) writeonly uniform image2D seen_colour;
layout(r32f) writeonly uniform image2D seen_inverse_depth;
layout(rgba16f) readonly uniform image2D behind_colour; // the picture
layout(r32f) readonly uniform image2D behind_inverse_depth;
uniform ivec2 from, to; // the pixels to visit, `to` excluded
uniform int taken;      // the mirror

const int STEPS = 64, HALVINGS = 6;
const float NEAREST_M = 0.05, FARTHEST_M = 1e4;
// A surface is hit within this share of its inverse depth; a ray farther behind it continues
const float THICK = 0.06;

float drawn_at(vec2 pixel) {
    return imageLoad(behind_inverse_depth, ivec2(pixel)).r;
}

void march(ivec2 p, vec3 ray, Met met) {
    vec3 start = ray * met.way, mirrored = reflect(normalize(ray), met.normal);
    float longest = mirrored.z > 0.0 ? (met.way - NEAREST_M) / mirrored.z : FARTHEST_M;
    vec3 end = start + mirrored * min(max(longest, 0.0), FARTHEST_M);
    // Pixel and inverse depth are linear between the two ends.
    vec3 a = vec3((start.xy / -start.z - tangent_start) / tangent_step, 1.0 / -start.z);
    vec3 along = vec3((end.xy / -end.z - tangent_start) / tangent_step, 1.0 / -end.z) - a;
    vec2 edge = vec2(imageSize(behind_inverse_depth)) - 0.01;
    vec2 border = mix((vec2(0.01) - a.xy) / along.xy, (edge - a.xy) / along.xy, greaterThan(along.xy, vec2(0.0)));
    border = mix(border, vec2(1.0), lessThan(abs(along.xy), vec2(1e-6)));
    float last = clamp(min(border.x, border.y), 0.0, 1.0), before = 0.0, hit = -1.0;
    bool was_before = false;
    for (int step = 1; step <= STEPS && hit < 0.0; ++step) {
        float here = last * float(step) / float(STEPS);
        vec3 q = a + along * here;
        float drawn = drawn_at(q.xy);
        bool is_before = q.z >= drawn;
        if (was_before && !is_before) {
            float low = before, high = here;
            for (int k = 0; k < HALVINGS; ++k) {
                float middle = 0.5 * (low + high);
                vec3 at = a + along * middle;
                bool ahead = at.z >= drawn_at(at.xy);
                low = ahead ? middle : low;
                high = ahead ? high : middle;
            }
            vec3 at = a + along * high;
            if (abs(at.z - drawn_at(at.xy)) <= THICK * drawn_at(at.xy)) hit = high;
        }
        was_before = is_before;
        before = here;
    }
    vec3 at = a + along * (hit < 0.0 ? last : hit);
    bool sky = hit < 0.0 && last == 1.0 && drawn_at(at.xy) == 0.0;
    if (hit < 0.0 && !sky) return;
    vec3 place = vec3(tangent_start + at.xy * tangent_step, -1.0) / at.z;
    imageStore(seen_colour, p, imageLoad(behind_colour, ivec2(at.xy)));
    imageStore(seen_inverse_depth, p, vec4(sky ? 0.0 : 1.0 / (met.way + distance(place, start) / length(ray))));
}

void main() {
    ivec2 p = first_pixel() + from;
    if (p.x >= to.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= to.y) break;
        vec3 ray = ray_of(vec2(p) + 0.5);
        Met met = meet_mirror(ray);
        if (met.mirror == taken) march(p, ray, met);
    }
}
