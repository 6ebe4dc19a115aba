// The light of a mirroring surface: its own light and, by Schlick's share, that of the world behind
// the mirror. A disturbed normal turns the mirrored ray; its hit is assumed to be as far along it
// as that of the undisturbed ray.
// Source: Schlick 1994, An Inexpensive BRDF Model for Physically-based Rendering, eq. 15.
#include "lib/mirrors.glsl"
uniform sampler2D seen; // coverage in alpha
uniform vec2 seen_pixel; // 1 / its size

float fresnel(float reflectivity, float cosine) {
    float grazing = 1.0 - clamp(cosine, 0.0, 1.0), square = grazing * grazing;
    return reflectivity + (1.0 - reflectivity) * square * square * grazing;
}

// The pixel where the disturbed ray sees its mirror image. inverse_depth: of the undisturbed ray's
// image, in 1/m.
vec2 disturbed_place(vec2 pixel, vec3 ray, Met met, vec3 normal, float inverse_depth) {
    vec3 turned = reflect(normalize(ray), normal);
    turned -= 2.0 * min(dot(turned, met.normal), 0.0) * met.normal; // no ray enters the mirror
    vec3 behind = turned - 2.0 * dot(turned, met.normal) * met.normal;
    vec3 image = ray * (met.way * inverse_depth) + behind * (max(1.0 - met.way * inverse_depth, 0.0) * length(ray));
    vec2 place = (image.xy / -image.z - tangent_start) / tangent_step;
    return image.z < 0.0 ? place : pixel;
}

// base: the surface's own light, covered. surface: as in frame.Reflection. own: the reflection at
// the pixel itself, inverse_depth its depth (below 0: unknown).
vec4 with_reflection(vec2 pixel, vec4 base, vec4 surface, vec4 own, float inverse_depth) {
    vec3 ray = ray_of(pixel);
    Met met = meet_mirror(ray);
    int mirror = max(met.mirror, 0);
    vec3 normal = met.normal;
    vec4 image = own;
#ifdef GLOSSY
    if (mirror_centre[mirror].w == 0.0) {
        vec3 tilted = mirror_right[mirror].xyz * surface.g + mirror_up[mirror].xyz * surface.b;
        normal = tilted + met.normal * sqrt(max(1.0 - dot(surface.gb, surface.gb), 0.0));
        vec2 place = disturbed_place(pixel, ray, met, normal, max(inverse_depth, 0.0));
        bool disturbed = any(notEqual(surface.gb, vec2(0.0))) && inverse_depth >= 0.0;
        vec4 there = textureLod(seen, place * seen_pixel, 0.0);
        image = disturbed && there.a >= 0.5 ? vec4(there.rgb / there.a, 1.0) : own;
    }
#endif
    float straight = mirror_reflectivity[mirror];
    float mirrored = clamp(surface.r / max(straight, 1e-4), 0.0, 1.0);
    float share = mirrored * fresnel(straight, -dot(normal, normalize(ray)));
    bool seen_here = met.mirror >= 0 && image.a > 0.0;
    return seen_here ? vec4(mix(base.rgb, image.rgb, share), base.a) : base;
}
