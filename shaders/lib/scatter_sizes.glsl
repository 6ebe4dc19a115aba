// The sizes of both pictures of a scatter, and how many pixels an invocation does.
#include "lib/rows.glsl"
uniform ivec2 late_size;
uniform ivec2 shown_size;
