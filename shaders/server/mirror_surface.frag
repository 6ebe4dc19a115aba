// A mirror's properties where the picture shows it: reflectivity, and the normal from a normal map.
// In: uv. Out: reflectivity at normal incidence (r), the normal's x and y along the mirror's right
// and up (g, b), coverage 1.
// Source: Akenine-Moeller et al. 2018, Real-Time Rendering, 6.7.2 (normal maps).
uniform sampler2D shown_inverse_depth; // of the picture
uniform float keep;                    // a little below 1: a surface does not hide itself
uniform float reflectivity;
#ifdef NORMAL_MAP
uniform sampler2D normal_map;
uniform float normal_scale;
in vec2 uv;
#endif

layout(location = 0) out vec4 surface;

void main() {
    vec2 tilt = vec2(0.0);
#ifdef NORMAL_MAP
    vec3 normal = texture(normal_map, uv).xyz * 2.0 - 254.0 / 255.0; // before a discard, for its derivatives; byte 127 is 0
    tilt = normalize(normal * vec3(normal_scale, normal_scale, 1.0)).xy;
#endif
    if (gl_FragCoord.w < texelFetch(shown_inverse_depth, ivec2(gl_FragCoord.xy), 0).r * keep) discard;
    surface = vec4(reflectivity, tilt, 1.0);
}
