// What the shaders know of a transparent sheet, and its texture. The meshes of a draw call may have
// different ones: each mesh names a slot of those that are bound.
// Source: GLSL 4.30 specification, 4.1.7.1 (the index of a sampler is the same for all
// invocations, or nothing is defined) and 8.9.4 (gradients).
layout(binding = 3) uniform sampler2D surfaces[SLOTS];

in vec2 uv;
flat in vec4 passes; // share of the light behind that passes where the sheet does not cover, by colour; its opacity
flat in uvec2 kind;  // slot of its texture; 1 if its back is not drawn

// Called before any discard: after one the neighbours' uv, and so the mip level, would be undefined.
vec4 sheet_texel() {
#if SLOTS == 1
    return texture(surfaces[0], uv);
#else
    vec2 right = dFdx(uv), up = dFdy(uv);
    vec4 texel = vec4(0.0);
    for (uint slot = 0u; slot < SLOTS; ++slot)
        if (slot == kind.x) texel = textureGrad(surfaces[slot], uv, right, up);
    return texel;
#endif
}

bool is_drawn() {
    return gl_FrontFacing || kind.y == 0u;
}
