// The sizes of both pictures of a scatter, and the number of pixels per invocation, for the pass
// over the rendered pixels (lib/scatter.glsl) and the pass over the shown ones
// (lib/scatter_resolve.glsl).
#include "lib/rows.glsl"
uniform ivec2 rendered_size;
uniform ivec2 shown_size;
