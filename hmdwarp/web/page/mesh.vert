// A grid over the rendered picture, each vertex moved by the depth of its pixel: what others ship.
// In: number of the vertex. Out: its place in the shown view, where it was rendered.
// Source: Mark et al. 1997, Post-Rendering 3D Warping, for the mesh; McMillan and Bishop 1995.
uniform sampler2D rendered_inverse_depth;
uniform mat3 H; // from rendered to shown pixels
uniform vec3 e;
uniform ivec2 shown_size, rendered_size;
uniform int cells; // on each side
out vec2 place;
out float found_inverse_depth;

const float NEAREST = 64.0; // 1/m, where the depth buffer begins

void main() {
    int cell = gl_VertexID / 6, corner = gl_VertexID % 6;
    ivec2 at = ivec2(cell % cells, cell / cells) + ivec2(corner == 1 || corner == 3 || corner == 4, corner == 2 || corner == 4 || corner == 5);
    vec2 pixel = vec2(at) / float(cells) * vec2(rendered_size);
    ivec2 texel = min(ivec2(pixel), rendered_size - 1);
    float depth = max(texelFetch(rendered_inverse_depth, texel, 0).r, 0.0);
    vec3 q = H * vec3(pixel, 1.0) + e * depth;
    place = pixel / vec2(rendered_size);
    found_inverse_depth = depth / q.z;
    gl_Position = vec4(2.0 * q.xy / vec2(shown_size) - q.z, q.z - 2.0 * depth / NEAREST, q.z);
}
