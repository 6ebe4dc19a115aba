// After a scatter of keys: copies to each shown pixel the colour of the rendered pixel that its key
// names; nothing landed: (0, 0, 0, 0). The shader's own `winner` reads the key and clears it for
// the next picture, which saves a clearing pass.
#include "lib/scatter_sizes.glsl"
layout(rgba16f) readonly uniform image2D rendered_colour;
layout(rgba16f) writeonly uniform image2D shown_colour;
#ifdef WRITES_DEPTH
layout(r32f) readonly uniform image2D rendered_inverse_depth;
layout(r32f) writeonly uniform image2D shown_inverse_depth;
#endif
ivec2 winner(uint slot); // the rendered pixel, (-1, -1) for none

// first: the lowest pixel of this invocation, inside the picture on x.
void resolve_all(ivec2 first) {
    for (int row = 0; row < ROWS; ++row) {
        ivec2 shown = first + ivec2(0, row);
        if (shown.y >= shown_size.y) break;
        ivec2 rendered = winner(uint(shown.y) * uint(shown_size.x) + uint(shown.x));
        vec4 colour = imageLoad(rendered_colour, max(rendered, ivec2(0)));
        imageStore(shown_colour, shown, rendered.x >= 0 ? colour : vec4(0.0));
#ifdef WRITES_DEPTH
        float depth = imageLoad(rendered_inverse_depth, max(rendered, ivec2(0))).r;
        float ratio = (H * vec3(vec2(rendered) + 0.5, 1.0)).z + e.z * depth;
        imageStore(shown_inverse_depth, shown, vec4(rendered.x >= 0 ? depth / ratio : -1.0));
#endif
    }
}
