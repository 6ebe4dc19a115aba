// A rectangle around what each photon may light.
// In: photons of three words: x and y; z and normal; power. Out: the rectangle's corners, and the
// photon, in the axes of the scene.
// Source: Crassin et al. 2013, CloudLight; Cigolle et al. 2014 (octahedral normals).
#include "lib/receivers.glsl"
#include "lib/octahedral.glsl"
uniform vec3 low;   // the cube that holds all photons
uniform float edge;
const float NEAR_M = 0.02;
const float ROOM = 1.01; // for what rounding does

in uvec3 in_photon;

flat out vec3 place;
flat out vec3 normal;
flat out vec3 power;

void main() {
    uvec3 steps = uvec3(in_photon.x & 65535u, in_photon.x >> 16, in_photon.y & 65535u);
    place = low + vec3(steps) * (edge / 65535.0);
    normal = normal_of(in_photon.y >> 16);
    uvec3 parts = uvec3(in_photon.z, in_photon.z >> 9, in_photon.z >> 18) & 511u;
    power = vec3(parts) * exp2(float(in_photon.z >> 27) - 24.0);
    vec3 middle = (place - eye) * scene_from_eye, facing = abs(normal * scene_from_eye);
    // A disc with its thickness to both sides, within the ball.
    vec3 reach = min(sqrt(max(1.0 - facing * facing, 0.0)) + OFF_PLANE * facing, vec3(1.0)) * (ROOM * radius);
    float nearest = max(-middle.z - reach.z, NEAR_M), farthest = -middle.z + reach.z;
    vec2 lowest = middle.xy - reach.xy, highest = middle.xy + reach.xy;
    lowest /= mix(vec2(farthest), vec2(nearest), vec2(lessThan(lowest, vec2(0.0))));
    highest /= mix(vec2(nearest), vec2(farthest), vec2(lessThan(highest, vec2(0.0))));
    vec2 corner = mix(lowest, highest, vec2(gl_VertexID & 1, gl_VertexID >> 1));
    corner = clamp(corner, low_tangents.xy, low_tangents.zw);
    vec2 share = (corner - low_tangents.xy) / (low_tangents.zw - low_tangents.xy);
    gl_Position = farthest > NEAR_M ? vec4(2.0 * share - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
