// A unit vector from two bytes, the lower first.
// In: as cloudlight.photons.octahedral() makes it. Out: the vector, off by at most 0.7 degrees.
// Source: Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors.
vec3 normal_of(uint word) {
    vec2 f = vec2(word & 255u, (word >> 8) & 255u) / 127.0 - 1.0;
    vec3 n = vec3(f, 1.0 - abs(f.x) - abs(f.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return normalize(n);
}
