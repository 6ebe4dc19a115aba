// The reflection in a curved mirror: where the mirrored ray meets the surroundings, drawn once
// around the ball's centre with their depths, and how far behind the surface its image appears.
// In: place and normal in the axes of the eye. Out: linear RGBA; inverse depth of the image in 1/m.
// Source: Popescu et al. 2006, Real-Time Reflection Mapping with Parallax (rays against depth);
// Coddington 1829 (the image), see hmdwarp/geometry/view.py.
#include "lib/cube.glsl"
#include "lib/mirrors.glsl"
uniform sampler2D around;               // the cube, axes of the world
uniform sampler2D around_inverse_depth; // along each face's own -z
uniform mat3 world_from_eye;
uniform float face_size;
uniform int taken; // the mirror

in vec3 place;
in vec3 normal;

layout(location = 0) out vec4 colour;
layout(location = 1) out float inverse_depth;

const int STEPS = 6;

void main() {
    vec3 ray = place / -place.z, towards = normalize(ray), n = normalize(normal);
    vec3 mirrored = reflect(towards, n), from_centre = place - mirror_centre[taken].xyz;
    vec2 pixel = 1.0 / vec2(textureSize(around, 0));
    // The cube is around the centre, the ray starts on the surface: iterate until the sampled place
    // is as far as the surface there.
    float away = 1e6;
    vec3 d = world_from_eye * mirrored;
    for (int step = 0; step < STEPS; ++step) {
        vec3 reach = abs(d);
        float depth = max(reach.x, max(reach.y, reach.z)) / length(d); // per unit of distance, along the face's -z
        float drawn = max(textureLod(around_inverse_depth, cube_place(d, face_size) * pixel, 0.0).r * depth, 1e-6);
        float b = dot(from_centre, mirrored), c = dot(from_centre, from_centre) - 1.0 / (drawn * drawn);
        away = max(sqrt(max(b * b - c, 0.0)) - b, 1e-3); // to the sphere of that distance around the centre
        d = world_from_eye * (from_centre + mirrored * away);
    }
    colour = vec4(textureLod(around, cube_place(d, face_size) * pixel, 0.0).rgb, 1.0);
    float cosine = max(-dot(towards, n), 1e-3);
    float behind = 1.0 / (1.0 / away + 2.0 / (mirror_centre[taken].w * cosine));
    inverse_depth = 1.0 / (-place.z + behind / length(ray));
    if (meet_mirror(ray).mirror != taken) discard;
}
