// The sizes of both pictures of a scatter, and how many pixels an invocation does: for the pass
// over the rendered pixels (lib/scatter.glsl) as for the pass over the shown ones
// (lib/scatter_resolve.glsl).
#include "lib/rows.glsl"
uniform ivec2 rendered_size;
uniform ivec2 shown_size;
