// What photons fall on, at low resolution: normals and factors of surfaces, and where they are.
// Splatting and what looks up the splatted light use the same code.
// Source: Crassin et al. 2013, CloudLight (deferred shading of photons).
uniform sampler2D receivers;      // normal; factor, 0 where lamps light nothing
uniform sampler2D receiver_depth; // inverse depth
uniform vec3 eye;                 // in the axes of the scene, from its origin
uniform mat3 scene_from_eye;      // turns only
uniform vec4 low_tangents;        // left, lower, right, upper edge of the low picture
uniform float radius;             // metres that a photon lights around it

// How far off the plane of what it lights, in radii, and the least cosine between normals. As in
// cloudlight/photons.py.
const float OFF_PLANE = 0.25;
const float LEAST_COSINE = 0.8;

vec3 receiver_place(ivec2 at, float inverse_depth) {
    vec2 share = (vec2(at) + 0.5) / vec2(textureSize(receivers, 0));
    return eye + scene_from_eye * (vec3(mix(low_tangents.xy, low_tangents.zw, share), -1.0) / inverse_depth);
}
