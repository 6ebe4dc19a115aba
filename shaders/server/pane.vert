// Puts the transparent sheets, or the overlay, where the eye sees them, exactly as scene.vert does,
// and hands on what the sheet is made of.
// In: metres relative to the scene's origin, to a body or to the head; number of the mesh. Out: clip
// space, w = metres along -z; uv; linear light and share of light that passes; what the mesh is made of.
// Source: as scene.vert.
struct Kind {
    mat4 clip_from_here;
    vec4 passes;
    uint slot, one_sided, unused[2];
};
layout(std430, binding = 0) readonly buffer Kinds { Kind kinds[]; };

invariant gl_Position; // the draws of one layer use two programs, which must agree to the last bit

in vec3 in_position;
in vec2 in_uv;
in vec3 in_light;
in vec3 in_coloured;
in uint in_mesh;

out vec2 uv;
out vec3 light;
out vec3 coloured;
flat out vec4 passes;
flat out uvec2 kind;

void main() {
    Kind mesh = kinds[in_mesh];
    uv = in_uv;
    light = in_light;
    coloured = in_coloured;
    passes = mesh.passes;
    kind = uvec2(mesh.slot, mesh.one_sided);
    gl_Position = mesh.clip_from_here * vec4(in_position, 1.0);
}
