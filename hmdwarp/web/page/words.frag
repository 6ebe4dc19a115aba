// A line for people over an eye's picture.
// In: its letters, sRGB, the top row first. Out: the same, blended by how much they cover.
// Source: none.
uniform sampler2D words;
uniform ivec2 corner, extent; // of the viewport, in pixels
out vec4 written;

void main() {
    vec2 at = (gl_FragCoord.xy - vec2(corner)) / vec2(extent);
    written = textureLod(words, vec2(at.x, 1.0 - at.y), 0.0);
}
