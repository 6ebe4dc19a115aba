// Which rendered pixels move between drawing and showing, and where to: p_moved ~ H p + e *
// inverse_depth, p in rendered pixels (centres at i + 0.5), as lib/warp_map.glsl has it. RIGID: one
// map for each body; a number beyond the table counts as static. SOFT: H is the identity, e the
// displacement of each pixel, in pixels times metres. IMAGES: read by imageLoad, which takes
// llvmpipe a fifth of the time.
#if IMAGES
layout(r32f) readonly uniform image2D rendered_inverse_depth;
#define AT(picture, pixel) imageLoad(picture, pixel)
#else
uniform sampler2D rendered_inverse_depth;
#define AT(picture, pixel) texelFetch(picture, pixel, 0)
#endif
uniform ivec2 rendered_size;
// Relative change of inverse depth from one pixel to the next, on each axis, up to which it is one
// surface
uniform vec2 steepest;
#if RIGID
#if IMAGES
// moderngl 5.13 lacks uniforms of this type, so it is bound here
layout(r16ui, binding = 2) readonly uniform uimage2D rendered_ids;
#else
uniform usampler2D rendered_ids;
#endif
uniform int body_count;
// Columns of H, and e; w of the first: 1 if it moves
layout(std430, binding = 0) readonly buffer Bodies { vec4 body_maps[]; };
#endif
#if SOFT
#if IMAGES
layout(rgba16f) readonly uniform image2D rendered_velocity;
#else
uniform sampler2D rendered_velocity; // m/s along the eye's axes, coverage
#endif
uniform mat3 pixel_from_eye;     // metres along the eye's axes to homogeneous pixels
uniform float seconds;           // for which motion is extrapolated
uniform float reach_m;           // the largest displacement
const uint SOFT_KEY = 0x10000u;  // one more than any body
const float TEAR_PX = 2.0;       // pixels by which neighbours may separate: a hand that passes a leg is another surface
#endif

const float LARGEST = 3.402823466e38; // the largest finite float32

bool is_depth(float r) { return r >= 0.0 && r <= LARGEST; }

// 1/m, -1 for a pixel without depth.
float known_inverse_depth(ivec2 pixel) {
    float r = AT(rendered_inverse_depth, clamp(pixel, ivec2(0), rendered_size - 1)).r;
    return is_depth(r) ? r : -1.0;
}

// The key of what a pixel moves with, if it has depth: 0 for nothing, else its body, or SOFT_KEY.
uint key_of(ivec2 pixel) {
    uint key = 0u;
#if RIGID
    uint id = AT(rendered_ids, pixel).r;
    uint slot = clamp(id, 1u, uint(max(body_count, 1))) - 1u;
    if (id == slot + 1u && body_count > 0 && body_maps[4u * slot].w > 0.0) key = id;
#endif
#if SOFT
    vec4 velocity = AT(rendered_velocity, pixel);
    if (key == 0u && velocity.a >= 0.5 && dot(abs(velocity.rgb), vec3(1.0)) > 0.0) key = SOFT_KEY;
#endif
    return key;
}

// The same for any pixel. Outside the picture nothing moves.
uint moves_with(ivec2 pixel) {
    ivec2 within = clamp(pixel, ivec2(0), rendered_size - 1);
    return within == pixel && known_inverse_depth(pixel) >= 0.0 ? key_of(within) : 0u;
}

#if SOFT && !IMAGES
// Displacement of a deforming pixel, in pixels times metres.
vec3 way_of(ivec2 pixel) {
    vec3 way = AT(rendered_velocity, clamp(pixel, ivec2(0), rendered_size - 1)).rgb * seconds;
    return pixel_from_eye * (way * min(1.0, reach_m / max(length(way), 1e-20)));
}

// New position of such a pixel's centre, in pixels.
vec2 goes_to(ivec2 pixel, float r) {
    vec3 q = vec3(vec2(pixel) + 0.5, 1.0) + way_of(pixel) * r;
    return q.xy / max(q.z, 1e-6);
}
#endif

struct Seen { ivec2 pixel; uint key; float r; };

Seen seen(ivec2 pixel) { return Seen(pixel, moves_with(pixel), known_inverse_depth(pixel)); }

// Whether two neighbours show one surface of one moving thing: at one depth, and not torn apart by
// motion.
bool joined(Seen a, Seen b) {
    vec2 apart = vec2(b.pixel - a.pixel);
    bool whole = a.key != 0u && a.key == b.key && abs(a.r - b.r) <= dot(steepest, abs(apart)) * min(a.r, b.r);
#if SOFT && !IMAGES
    vec2 strain = abs(goes_to(b.pixel, b.r) - goes_to(a.pixel, a.r) - apart);
    whole = whole && (a.key != SOFT_KEY || max(strain.x, strain.y) <= TEAR_PX);
#endif
    return whole;
}
