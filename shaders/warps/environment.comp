// Gathers each shown pixel from the cube map around the late eye: the face that its ray leaves through, and one bilinear look there.
// In: shown pixel; H gives the ray's direction in the axes of the late eye (base). Out: what the cube holds; coverage 1 all around.
// Source: Greene 1986, Environment Mapping and Other Applications of World Projections; faces as in hmdwarp/geometry/cube.py.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include OUTPUT
uniform float face_size; // of one face, with its border of one pixel

// The face's column and row in the picture, and the ray's coordinates to its right, up and ahead.
void face_of(vec3 d, out vec2 cell, out vec3 along) {
    vec3 reach = abs(d);
    bool sideways = reach.x > reach.z, upright = reach.y > max(reach.x, reach.z);
    float x = d.x < 0.0 ? -1.0 : 1.0, y = d.y < 0.0 ? -1.0 : 1.0, z = d.z > 0.0 ? -1.0 : 1.0;
    cell = sideways ? vec2(1.0 + x, 0.0) : vec2(1.0, d.z > 0.0 ? 1.0 : 0.0);
    along = sideways ? vec3(x * d.z, d.y, reach.x) : vec3(z * d.x, d.y, reach.z);
    cell = upright ? vec2(1.0 + y, 1.0) : cell;
    along = upright ? vec3(d.x, y * d.z, reach.y) : along;
}

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    vec2 cell;
    vec3 along;
    face_of(base, cell, along);
    vec2 within = along.xy / along.z * (0.5 * face_size - 1.0) + 0.5 * face_size;
    return covered_average(cell * face_size + within);
}
