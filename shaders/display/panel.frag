// A pixel of a widget: its ink times its tint, both sRGB-encoded (user interfaces blend encoded
// values, not light).
// In: the uv and tint between the corners; the atlas of glyphs, or the finished panel. Out: colour
// and alpha, blended by the caller.
// Source: Dear ImGui, docs/BACKENDS.md.
uniform sampler2D ink;

in vec2 vertex_uv;
in vec4 vertex_tint;

out vec4 colour;

void main() {
    colour = vertex_tint * texture(ink, vertex_uv);
}
