// Show in each mirror what the eye sees in it now, instead of what it saw when it was drawn.
// In: the rendered picture, the light in mirrors, where it can be trusted. Out: the rendered picture
// with the mirrors' light moved; what has none stays bit for bit.
// Source: Sinha et al. 2012, section 5 (both layers by their own depth, added).
#include "lib/rows.glsl"
#define IMAGES
#include "effects/mirrored.glsl"
layout(rgba16f) readonly uniform image2D given;
layout(rgba16f) writeonly uniform image2D written;
uniform sampler2D light_before, trust;
uniform vec2 rendered_pixel; // 1 / rendered_size
uniform vec3 shown_eye;

vec4 joined_at(ivec2 pixel) {
    vec4 colour = imageLoad(given, pixel);
    float own = depth_at(pixel);
    vec3 from = vec3(vec2(pixel) + 0.5, 1.0);
    float part = textureLod(trust, from.xy * image_depth_pixel, 0.0).r;
    if (!(part > 0.0 && image_at(from.xy, own) < own)) return colour;
    vec2 place = image_seen(from, own, shown_eye);
    vec4 seen = textureLod(light_before, place * rendered_pixel, 0.0), here = texelFetch(light_before, pixel, 0);
    if (place.x < 0.0 || seen.a < 0.5 || here.a < 0.5) return colour;
    return vec4(max(colour.rgb + part * colour.a * (seen.rgb / seen.a - here.rgb), vec3(0.0)), colour.a);
}

void main() {
    ivec2 p = first_pixel();
    if (p.x >= rendered_size.x) return;
    for (int row = 0; row < ROWS; ++row, ++p.y) {
        if (p.y >= rendered_size.y) break;
        imageStore(written, p, joined_at(p));
    }
}
