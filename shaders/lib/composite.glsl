// Add one more picture to the shown one: for every pixel of a column, the nearest hit of its ray
// with that picture's surface, if `belongs` accepts it over the previous hit. Three guesses are
// tried: the nearest and the farthest depth that landed in the pixel and its eight neighbours, and
// the one that landed in the pixel itself. So a surface that comes closer has no cracks up to three
// times its size.
#include "lib/rows.glsl"
#include "lib/warp_map.glsl"
#include "lib/meeting.glsl"
#include "lib/seed_keys.glsl"
layout(rgba16f) writeonly uniform image2D shown_colour;
layout(BEST) uniform image2D best; // r: inverse depth of the best hit so far, -1 for none
uniform ivec2 shown_size;
const int PIECE = 8; // as many invocations as llvmpipe runs at a time
// x: index; y: stamp when it was listed
layout(std430, binding = 1) buffer Pieces { uint piece_groups[3]; uint piece_count; uvec2 pieces[]; };
#if PASS == 1
const bool is_first = true;
#else
const bool is_first = false;
#endif
uniform int guesses; // 3; a constant would be unrolled, and llvmpipe would run all three steps everywhere

// Whether any hit may be accepted, by the nearest guess: most pixels need no second test.
bool may_belong(Ray ray, float nearest, vec4 before);
// Whether the hit is accepted over the previous one (-1 for none); outputs what to remember of it.
bool belongs(vec2 shown, Ray ray, Meeting found, vec4 before, out vec4 after);

// Keys of three pixels in a row: the nearest, the farthest less 1 (so that nothing, 0, is the
// largest uint), and the middle one.
uvec3 three_keys(ivec2 middle) {
    int y = clamp(middle.y, 0, shown_size.y - 1) * shown_size.x;
    uint a = seed_of[y + max(middle.x - 1, 0)], b = seed_of[y + middle.x], c = seed_of[y + min(middle.x + 1, shown_size.x - 1)];
    return uvec3(max(max(a, b), c), min(min(a - 1u, b - 1u), c - 1u), b);
}

int pieces_in_a_row() {
    return (shown_size.x + PIECE - 1) / PIECE;
}

#if PASS == 0
uniform uint stamp; // unique to each run

ivec2 first_of_column() {
    return first_pixel();
}

bool may_change(ivec2 pixel, vec3 base, uvec3 below, uvec3 here, uvec3 above) {
    uint nearest = max(max(below.x, here.x), above.x);
    vec4 before = imageLoad(best, pixel);
    return nearest != 0u && (before.r < 0.0 || may_belong(ray_of(base, e), seed_depth(nearest), before));
}

void list_piece(ivec2 first) {
    uint piece = uint(first.y / ROWS * pieces_in_a_row() + first.x / PIECE);
    if (atomicExchange(pieces[piece].y, stamp) == stamp) return;
    uint slot = atomicAdd(piece_count, 1u);
    pieces[slot].x = piece;
    if (slot % uint(GROUP_X / PIECE) == 0u) atomicAdd(piece_groups[0], 1u);
}
#else
// The lowest pixel of an invocation's column; outside the picture if it has no work.
ivec2 first_of_column() {
#if PASS == 1
    return first_pixel();
#else
    uint index = gl_GlobalInvocationID.x / uint(PIECE), lane = gl_GlobalInvocationID.x % uint(PIECE);
    int piece = int(pieces[min(index, max(piece_count, 1u) - 1u)].x), wide = pieces_in_a_row();
    return index < piece_count ? ivec2(piece % wide * PIECE + int(lane), piece / wide * ROWS) : shown_size;
#endif
}

void composite(ivec2 pixel, vec3 base, uvec3 below, uvec3 here, uvec3 above) {
    vec2 shown = vec2(pixel) + 0.5;
    Ray ray = ray_of(base, e);
    uint nearest = max(max(below.x, here.x), above.x), farthest = min(min(below.y, here.y), above.y) + 1u;
    vec4 before = is_first ? vec4(-1.0) : imageLoad(best, pixel), after = vec4(-1.0);
    float guess = seed_depth(nearest);
    bool pending = is_first || before.r < 0.0 || may_belong(ray, guess, before);
    Meeting found = Meeting(-1.0, vec2(0.0), vec2(0.0), bvec2(false));
    for (int tried = 0; tried < guesses && pending; ++tried) {
        found = meet(ray, guess);
        guess = seed_depth(tried == 0 ? here.z : farthest);
        pending = found.depth < 0.0;
    }
    vec4 sum = textureLod(rendered_colour, found.colour_at * rendered_pixel, 0.0);
    bool shows = found.depth >= 0.0 && sum.a >= 0.5 && belongs(shown, ray, found, before, after);
    if (shows || is_first) {
        imageStore(shown_colour, pixel, shows ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0));
        imageStore(best, pixel, shows ? after : vec4(-1.0));
    }
}
#endif

void composite_column(ivec2 first) {
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    uvec3 below = three_keys(first - ivec2(0, 1)), here = three_keys(first);
#if PASS == 0
    bool wanted = false;
#endif
    for (int row = 0; row < ROWS; ++row) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.y >= shown_size.y) break;
        uvec3 above = three_keys(pixel + ivec2(0, 1));
#if PASS == 0
        wanted = wanted || may_change(pixel, base + H[1] * float(row), below, here, above);
#else
        composite(pixel, base + H[1] * float(row), below, here, above);
#endif
        below = here;
        here = above;
    }
#if PASS == 0
    if (wanted) list_piece(first);
#endif
}
