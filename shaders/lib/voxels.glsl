// Light from a grid of voxels, gathered along cones. Each cell holds, for each way along an axis, the
// surface in it that faces against that way: its area in faces of a cell, and its light times that.
// Levels hold means, so that a cone meets as much area as there is, at any angle.
// Source: Crassin et al. 2011, Interactive Indirect Illumination Using Voxel Cone Tracing.
#define MOST_CONES 32
layout(binding = 8) uniform sampler3D facing[6]; // seen along +x, -x, +y, -y, +z, -z
uniform vec3 grid_low;    // metres from the scene's origin
uniform float cell_m;
uniform float grid_size;  // cells a side
uniform vec3 cones[MOST_CONES]; // ways in axes whose z is the normal; all have the same share
uniform int cone_count;
uniform float cone_width; // diameter at a distance of 1
uniform vec3 sky_zenith;
uniform vec3 sky_horizon;
uniform vec3 sky_ground;

// What crosses a surface once, at any angle, is let through by e^-STOPS. More of it makes what fills
// a part of a cell stop too much. Both constants are those of the least error in the lit rooms.
const float STOPS = 4.0;
const float STEP = 0.5; // of a cone's diameter
const float WIDEST = 0.25; // of the grid: coarser cells let walls through

vec4 area_seen(vec3 at, vec3 way, float level) {
    vec4 seen = abs(way.x) * (way.x > 0.0 ? textureLod(facing[0], at, level) : textureLod(facing[1], at, level));
    seen += abs(way.y) * (way.y > 0.0 ? textureLod(facing[2], at, level) : textureLod(facing[3], at, level));
    return seen + abs(way.z) * (way.z > 0.0 ? textureLod(facing[4], at, level) : textureLod(facing[5], at, level));
}

vec3 cone_light(vec3 from, vec3 way) {
    vec3 leaves = max(-from / way, (grid_size - from) / way); // inf along an axis that the way does not follow
    float last = min(leaves.x, min(leaves.y, leaves.z)), widest = WIDEST * grid_size;
    float passes = 1.0, t = 0.0;
    vec3 light = vec3(0.0);
    while (t < last && passes > 1e-3) {
        float advance = min(STEP * clamp(cone_width * t, 1.0, widest), last - t);
        float middle = t + 0.5 * advance;
        vec4 seen = area_seen((from + middle * way) / grid_size, way, log2(clamp(cone_width * middle, 1.0, widest)));
        float stopped = 1.0 - exp(-STOPS * advance * seen.a);
        light += passes * stopped / max(seen.a, 1e-6) * seen.rgb;
        passes *= 1.0 - stopped;
        t += advance;
        if (advance <= 0.0) break;
    }
    float up = way.y;
    return light + passes * mix(sky_horizon, up > 0.0 ? sky_zenith : sky_ground, sqrt(abs(up)));
}

vec3 voxel_light(vec3 place, vec3 normal) {
    vec3 side = normalize(abs(normal.y) < 0.9 ? cross(normal, vec3(0.0, 1.0, 0.0)) : cross(normal, vec3(1.0, 0.0, 0.0)));
    mat3 axes = mat3(side, cross(normal, side), normal);
    // A slanted surface also faces against ways that leave it: start where it ends.
    float off = dot(abs(normal), vec3(1.0)) - 1.0;
    vec3 from = (place - grid_low) / cell_m + off * normal, total = vec3(0.0);
    for (int i = 0; i < cone_count; ++i) total += cone_light(from, axes * cones[i]);
    return total / float(cone_count);
}
