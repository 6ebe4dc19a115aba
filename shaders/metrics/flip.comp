// Filters along columns what flip_rows.comp has filtered along rows, and compares both pictures.
// In: 7 floats a pixel, the reference's rows and then the other's. Out: FLIP of each pixel, 0 to 1.
// Source: Andersson et al. 2020, FLIP, eq. 4 to 12.
#define ROWS 4
layout(local_size_x = 64, local_size_y = 1) in;
layout(rgba32f, binding = 2) readonly uniform image2D between;
layout(r32f, binding = 3) writeonly uniform image2D map;
uniform ivec2 size;
uniform mat3 white_from_rgb;
uniform mat3 rgb_from_white;
uniform vec4 sight[2 * RADIUS + 1];
uniform vec3 shape[2 * RADIUS + 1];
uniform float most; // colour difference of green and blue

const float POWER = 0.7, KNEE = 0.4, AT_KNEE = 0.95;

struct Looks {
    vec3 colour; // L*a*b* with a and b scaled by L (Hunt)
    float edge, point;
};

vec3 hunt_of(vec3 y_cx_cz) {
    float y = (y_cx_cz.x + 16.0) / 116.0;
    vec3 rgb = clamp(rgb_from_white * vec3(y + y_cx_cz.y / 500.0, y, y - y_cx_cz.z / 200.0), 0.0, 1.0);
    vec3 w = white_from_rgb * rgb;
    vec3 f = mix(w / (3.0 * 36.0 / 841.0) + 4.0 / 29.0, pow(w, vec3(1.0 / 3.0)), greaterThan(w, vec3(216.0 / 24389.0)));
    float lightness = 116.0 * f.y - 16.0;
    return vec3(lightness, 0.01 * lightness * vec2(500.0 * (f.x - f.y), 200.0 * (f.y - f.z)));
}

void look(int first, ivec2 q, out Looks looks[ROWS]) {
    vec4 colour[ROWS + 2 * RADIUS];
    vec3 formed[ROWS + 2 * RADIUS];
    for (int k = 0; k < ROWS + 2 * RADIUS; ++k) {
        ivec2 at = ivec2(q.x, first + clamp(q.y + k - RADIUS, 0, size.y - 1));
        colour[k] = imageLoad(between, at);
        formed[k] = imageLoad(between, at + ivec2(size.x, 0)).xyz;
    }
    for (int n = 0; n < ROWS; ++n) {
        vec4 sum = vec4(0.0);
        vec4 both = vec4(0.0); // edges across and along, points across and along
        for (int k = 0; k <= 2 * RADIUS; ++k) {
            sum += sight[k] * colour[n + k];
            both += vec4(shape[k].x, shape[k].y, shape[k].x, shape[k].z) * formed[n + k].yxzx;
        }
        looks[n].colour = hunt_of(vec3(sum.xy, sum.z + sum.w));
        looks[n].edge = length(both.xy);
        looks[n].point = length(both.zw);
    }
}

void main() {
    ivec2 q = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
    if (q.x >= size.x || q.y >= size.y) return;
    Looks reference[ROWS], other[ROWS];
    look(0, q, reference);
    look(size.y, q, other);
    for (int n = 0; n < ROWS; ++n) {
        vec3 apart = reference[n].colour - other[n].colour;
        float d = pow(abs(apart.x) + length(apart.yz), POWER);
        float knee = KNEE * most;
        d = d < knee ? d * AT_KNEE / knee : AT_KNEE + (d - knee) / (most - knee) * (1.0 - AT_KNEE);
        float shapes_apart = max(abs(reference[n].edge - other[n].edge), abs(reference[n].point - other[n].point));
        float error = pow(d, 1.0 - sqrt(shapes_apart * 0.70710678));
        if (q.y + n < size.y) imageStore(map, q + ivec2(0, n), vec4(error));
    }
}
