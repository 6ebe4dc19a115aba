// The depth of a cut-out sheet, such as a fence: texels that pass less than half of the light have
// the sheet's depth, the others are discarded.
// In: uv of the sheet. Out: inverse depth in 1/m.
// Source: alpha test, OpenGL 1.5 specification, 4.1.4.
#include "lib/sheet.glsl"

layout(location = 0) out float inverse_depth;

void main() {
    float share = passes.a * sheet_texel().a;
    if (share < 0.5 || !is_drawn()) discard;
    inverse_depth = gl_FragCoord.w;
}
