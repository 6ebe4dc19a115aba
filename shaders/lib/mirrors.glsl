// The mirrors of a picture in the axes of an eye, and the one that a ray meets. Rays have z = -1,
// so that `way` is a depth.
// Rows of the uniforms: hmdwarp/geometry/view.py.
#define MOST_MIRRORS 8
uniform int mirror_count;
uniform vec4 mirror_centre[MOST_MIRRORS]; // centre and, in w, the radius of a ball, 0 for a plane
uniform vec4 mirror_right[MOST_MIRRORS];  // unit vector, and half the length
uniform vec4 mirror_up[MOST_MIRRORS];
uniform float mirror_reflectivity[MOST_MIRRORS]; // at normal incidence
uniform vec2 tangent_start, tangent_step; // of the pixels' rays

// A plane mirror extends this far beyond its edges where no other mirror is: its image moves
// against its frame when the head moves.
const float APRON_M = 0.4;
const float FAR = 1e30;

struct Met {
    int mirror; // -1: none
    float way;
    vec3 normal; // unit, towards the eye's side
};

vec3 ray_of(vec2 pixel) {
    return vec3(tangent_start + pixel * tangent_step, -1.0);
}

// The distance along `ray` to a ball around `centre`, FAR if it is missed.
float way_to_ball(vec3 ray, vec3 centre, float radius) {
    float along = dot(ray, centre), square = dot(ray, ray);
    vec3 beside = centre - ray * (along / square); // the difference of squares would lose the digits of a far ball
    float inside = radius * radius - dot(beside, beside);
    float way = (along - sqrt(max(inside, 0.0) * square)) / square;
    return inside >= 0.0 && way > 0.0 ? way : FAR;
}

// The nearest mirror; without any, the nearest whose apron is hit.
Met meet_mirror(vec3 ray) {
    Met met = Met(-1, FAR, vec3(0.0)), apron = met;
    for (int i = 0; i < mirror_count; ++i) {
        vec4 centre = mirror_centre[i], right = mirror_right[i], up = mirror_up[i];
        vec3 normal = cross(right.xyz, up.xyz);
        float towards = dot(normal, ray);
        float way = towards < 0.0 ? dot(normal, centre.xyz) / towards : FAR;
        vec3 off = ray * way - centre.xyz;
        float beyond = max(abs(dot(off, right.xyz)) - right.w, abs(dot(off, up.xyz)) - up.w);
        bool met_plane = way > 0.0 && way < FAR;
        if (centre.w > 0.0) {
            way = way_to_ball(ray, centre.xyz, centre.w);
            normal = (ray * way - centre.xyz) / centre.w;
            beyond = 0.0;
            met_plane = way < FAR;
        }
        if (met_plane && beyond <= 0.0 && way < met.way) met = Met(i, way, normal);
        if (met_plane && beyond <= APRON_M && way < apron.way) apron = Met(i, way, normal);
    }
    if (met.mirror < 0) return apron;
    return met;
}
