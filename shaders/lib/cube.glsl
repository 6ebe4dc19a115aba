// Sampling of the six faces of hmdwarp/geometry/cube.py, laid side by side in one picture.
// Source: Greene 1986, Environment Mapping and Other Applications of World Projections.
// The face's column and row in the picture, and the ray's coordinates to its right, up and ahead.
void face_of(vec3 d, out vec2 cell, out vec3 along) {
    vec3 reach = abs(d);
    bool sideways = reach.x > reach.z, upright = reach.y > max(reach.x, reach.z);
    float x = d.x < 0.0 ? -1.0 : 1.0, y = d.y < 0.0 ? -1.0 : 1.0, z = d.z > 0.0 ? -1.0 : 1.0;
    cell = sideways ? vec2(1.0 + x, 0.0) : vec2(1.0, d.z > 0.0 ? 1.0 : 0.0);
    along = sideways ? vec3(x * d.z, d.y, reach.x) : vec3(z * d.x, d.y, reach.z);
    cell = upright ? vec2(1.0 + y, 1.0) : cell;
    along = upright ? vec3(d.x, y * d.z, reach.y) : along;
}

// Where direction `d`, in the cube's own axes, falls in the picture, in pixels; face_size: of one
// face, with its border.
vec2 cube_place(vec3 d, float face_size) {
    vec2 cell;
    vec3 along;
    face_of(d, cell, along);
    return cell * face_size + along.xy / along.z * (0.5 * face_size - 1.0) + 0.5 * face_size;
}
