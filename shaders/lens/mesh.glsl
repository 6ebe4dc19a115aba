// A lens by a mesh: where a panel pixel lies, in metres from the middle, and the tangent that each
// colour channel shows there, bilinear between the points of a grid over the panel.
uniform vec4 lens_from_panel;    // scale xy, offset zw: panel pixel -> metres from the middle
uniform vec4 shown_from_tangent; // scale xy, offset zw: tangent -> 0..1 of the shown picture
uniform vec2 lens_panel;         // width and height in metres
uniform sampler2D lens_mesh;     // tangents: the points of red, above them those of green and of blue

void prepare_lens() {
}

vec2 tangent_of(int colour, vec2 on_lens) {
    ivec2 points = textureSize(lens_mesh, 0) / ivec2(1, 3);
    vec2 at = (on_lens / lens_panel + 0.5) * vec2(points - 1);
    ivec2 low = clamp(ivec2(at), ivec2(0), points - 2), texel = low + ivec2(0, colour * points.y);
    vec2 part = at - vec2(low);
    vec2 a = texelFetch(lens_mesh, texel, 0).xy, b = texelFetch(lens_mesh, texel + ivec2(1, 0), 0).xy;
    vec2 c = texelFetch(lens_mesh, texel + ivec2(0, 1), 0).xy, d = texelFetch(lens_mesh, texel + ivec2(1, 1), 0).xy;
    return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}

mat3x2 lens_tangents(vec2 on_lens) {
    return mat3x2(tangent_of(0, on_lens), tangent_of(1, on_lens), tangent_of(2, on_lens));
}
