// Direct light of moving lamps, with shadows by rays against every blocker. Server and clients use
// the same code.
// Source: as hmdwarp/cloudlight/radiosity.py; Moeller and Trumbore 1997 (rays in a triangle's axes).
uniform sampler2D blockers;  // a column for each triangle: three rows that take a point to its axes
uniform int blocker_count;
uniform int lamp_count;
uniform vec4 lamp_place[4];  // a point's place in the scene, 1; or the way to a sun, 0
uniform vec4 lamp_cone[4];   // a spot sends clamp(xyz . d + w, 0, 1)^2 along d; others 0, 0, 0, 1
uniform vec4 lamp_colour[4]; // what a white surface shows 1 m away, or under the sun

const float OFF_M = 1e-3;     // in front of the surface, so that it is not its own shadow
const float NEAREST_M2 = 1e-4; // a nearer surface gets no more light

bool blocked(vec4 from, vec4 way, float longest) {
    for (int i = 0; i < blocker_count; ++i) {
        vec4 across = texelFetch(blockers, ivec2(0, i), 0), up = texelFetch(blockers, ivec2(1, i), 0);
        vec4 off = texelFetch(blockers, ivec2(2, i), 0);
        float t = -dot(off, from) / dot(off, way);
        vec4 hit = from + t * way;
        float u = dot(across, hit), v = dot(up, hit);
        if (t > 0.0 && t < longest && u >= 0.0 && v >= 0.0 && u + v <= 1.0) return true;
    }
    return false;
}

vec3 direct_light(vec3 place, vec3 normal) {
    vec3 total = vec3(0.0);
    for (int i = 0; i < lamp_count; ++i) {
        vec3 from = place + OFF_M * normal;
        vec3 way = lamp_place[i].xyz - from * lamp_place[i].w;
        float square = max(dot(way, way), 1e-12);
        float cosine = dot(way, normal) * inversesqrt(square);
        float fades = clamp(lamp_cone[i].w - dot(lamp_cone[i].xyz, way) * inversesqrt(square), 0.0, 1.0);
        if (cosine <= 0.0 || fades <= 0.0) continue;
        bool is_point = lamp_place[i].w != 0.0;
        if (blocked(vec4(from, 1.0), vec4(way, 0.0), is_point ? 1.0 : 3e38)) continue;
        total += fades * fades * lamp_colour[i].rgb * (is_point ? cosine / max(square, NEAREST_M2) : cosine);
    }
    return total;
}
