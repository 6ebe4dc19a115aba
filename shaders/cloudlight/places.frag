// Where each pixel's surface is and which way it faces, for lamps that light it.
// In: place in metres from the scene's origin, normal, place in the light atlas. Out: place, 1 where
// lamps light it; normal.
// Source: Saito and Takahashi 1990, Comprehensible Rendering of 3-D Shapes (geometric buffers).
in vec3 place;
in vec3 normal;
in vec2 light_uv;

layout(location = 0) out vec4 shown_place;
layout(location = 1) out vec4 shown_normal;

void main() {
    shown_place = vec4(place, light_uv.x >= 0.0 ? 1.0 : 0.0);
    shown_normal = vec4(normalize(normal), 0.0);
}
