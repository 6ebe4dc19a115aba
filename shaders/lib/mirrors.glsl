// The mirrors of a picture in the axes of an eye, and which of them a ray meets. Rays have z = -1, so that `way` is a depth.
// Rows of the uniforms: hmdwarp/geometry/mirror.py.
#define MOST_MIRRORS 8
uniform int plane_count, mirror_count;    // plane ones come first
uniform vec4 mirror_shape[MOST_MIRRORS];  // a plane: unit normal n, and n * c (c: its centre). A ball: centre, radius
uniform vec4 mirror_right[MOST_MIRRORS];  // of a plane: unit vector r, and r * c
uniform vec4 mirror_up[MOST_MIRRORS];
uniform vec2 mirror_half[MOST_MIRRORS];   // half lengths to the right and up
uniform float mirror_reflectivity[MOST_MIRRORS]; // straight on
uniform vec2 tangent_start, tangent_step; // of the rays of pixels

// A plane mirror counts this far beyond its edges where no other is: what it shows moves against its frame when the head moves.
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

// How far along `ray` it meets a ball around `centre`, FAR if it does not.
float way_to_ball(vec3 ray, vec3 centre, float radius) {
    float along = dot(ray, centre), square = dot(ray, ray);
    vec3 beside = centre - ray * (along / square); // the difference of squares would lose the digits of a far ball
    float inside = radius * radius - dot(beside, beside);
    float way = (along - sqrt(max(inside, 0.0) * square)) / square;
    return inside >= 0.0 && way > 0.0 ? way : FAR;
}

// The nearest mirror; where there is none, the nearest of those whose apron is met.
Met meet_mirror(vec3 ray) {
    int met = -1, apron = -1;
    float way = FAR, apron_way = FAR;
    for (int i = 0; i < plane_count; ++i) {
        vec4 plane = mirror_shape[i], right = mirror_right[i], up = mirror_up[i];
        float towards = dot(plane.xyz, ray), here = plane.w / towards;
        vec2 off = vec2(dot(right.xyz, ray), dot(up.xyz, ray)) * here - vec2(right.w, up.w);
        vec2 beyond = abs(off) - mirror_half[i];
        float farthest = max(beyond.x, beyond.y);
        bool from_before = towards < 0.0 && here > 0.0;
        bool nearer = from_before && farthest <= 0.0 && here < way, apron_nearer = from_before && farthest <= APRON_M && here < apron_way;
        met = nearer ? i : met;
        way = nearer ? here : way;
        apron = apron_nearer ? i : apron;
        apron_way = apron_nearer ? here : apron_way;
    }
    for (int i = plane_count; i < mirror_count; ++i) {
        float here = way_to_ball(ray, mirror_shape[i].xyz, mirror_shape[i].w);
        met = here < way ? i : met;
        way = min(way, here);
    }
    way = met < 0 ? apron_way : way;
    met = met < 0 ? apron : met;
    vec4 shape = mirror_shape[max(met, 0)];
    return Met(met, way, met < plane_count ? shape.xyz : (ray * way - shape.xyz) / shape.w);
}
