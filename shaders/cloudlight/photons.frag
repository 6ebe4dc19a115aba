// What one photon gives to a pixel; the blend adds them.
// In: a photon. Out: light, as a white surface shows it.
// Source: Silverman 1986, Density Estimation for Statistics and Data Analysis, 4.2.1 (the kernel).
#include "lib/receivers.glsl"
const float PI = 3.14159265;

flat in vec3 place;
flat in vec3 normal;
flat in vec3 power;

layout(location = 0) out vec4 light;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 receiver = texelFetch(receivers, at, 0);
    float inverse_depth = texelFetch(receiver_depth, at, 0).r;
    light = vec4(0.0);
    if (inverse_depth <= 0.0 || dot(receiver.xyz, normal) < LEAST_COSINE) return;
    vec3 off = receiver_place(at, inverse_depth) - place;
    if (abs(dot(off, normal)) > OFF_PLANE * radius) return;
    float share = max(1.0 - dot(off, off) / (radius * radius), 0.0) * 2.0 / (PI * radius * radius);
    light = vec4(receiver.w * share * power, 0.0);
}
