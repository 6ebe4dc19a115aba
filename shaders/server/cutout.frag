// How far away the laths of a fence of alpha are: what lets less than half of the light pass is as
// far as the sheet, the rest is not there.
// In: uv of the sheet. Out: inverse depth in 1/m.
// Source: alpha test, OpenGL 1.5 specification, 4.1.4.
#include "lib/sheet.glsl"

layout(location = 0) out float inverse_depth;

void main() {
    float share = passes.a * sheet_texel().a;
    if (share < 0.5 || !is_drawn()) discard;
    inverse_depth = gl_FragCoord.w;
}
