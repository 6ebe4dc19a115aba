// Gathers each shown pixel from the cube map around the rendered eye: the face that its ray leaves
// through, and one bilinear sample there.
// In: shown pixel; H gives the ray's direction in the axes of the rendered eye (base). Out: the
// cube's colour; coverage 1 everywhere.
// Source: Greene 1986, Environment Mapping and Other Applications of World Projections; faces as in
// hmdwarp/geometry/cube.py.
#include "lib/warp_map.glsl"
#include "lib/gather.glsl"
#include "lib/cube.glsl"
#include OUTPUT
uniform float face_size; // of one face, with its border of one pixel

vec4 gathered(vec2 shown, vec3 base, vec3 parallax) {
    return covered_average(cube_place(base, face_size));
}
