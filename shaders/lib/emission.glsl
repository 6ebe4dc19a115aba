// What a surface emits by itself, drawn on top of what the light shows.
// In: uv of the surface. Out: linear light.
uniform sampler2D emission;
uniform vec3 emission_factor;

vec3 emitted(vec2 uv) {
    return texture(emission, uv).rgb * emission_factor;
}
