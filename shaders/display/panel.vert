// The corners of a widget, from pixels of the panel counted from its top left corner, as Dear ImGui
// supplies them.
// In: position_px (+y down), atlas coordinates, colour. Out: clip space, +y up; the other two
// unchanged.
// Source: Dear ImGui, docs/BACKENDS.md: draw lists are triangles in pixels with one texture and one
// clip rectangle a command.
uniform vec2 panel_size; // pixels

in vec2 position_px;
in vec2 ink_uv;
in vec4 tint;

out vec2 vertex_uv;
out vec4 vertex_tint;

void main() {
    vertex_uv = ink_uv;
    vertex_tint = tint;
    vec2 across = position_px / panel_size;
    gl_Position = vec4(2.0 * across.x - 1.0, 1.0 - 2.0 * across.y, 0.0, 1.0);
}
