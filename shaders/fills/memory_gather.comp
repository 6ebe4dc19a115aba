// Fill holes from one picture with depth: where the ray of an empty pixel meets the surface in the
// picture.
// In: the shown picture's coverage; the picture, and guesses of what lands where. Out: colour and
// inverse depth of the hits in holes.
// Source: Bowles et al. 2012, Iterative Image Warping (the gather); Mark et al. 1997 (of several
// pictures, nearer and better sampled wins).
#define ROWS 4
#include "lib/hole_pieces.glsl"
#include "lib/warp_map.glsl"
#include "lib/meeting.glsl"
#include "lib/seed_keys.glsl"
layout(rgba16f) readonly uniform image2D shown_colour;
layout(rgba16f) writeonly uniform image2D filled_colour;
layout(r32f) writeonly uniform image2D filled_depth; // 1 x 1 where no pass reads depth
// r: inverse depth of the fill, -1 for nothing; g: its sampling density
layout(rg32f) uniform image2D best;
uniform ivec2 cells;                // of the guesses; the picture itself may be coarser than the shown one
uniform vec2 cells_per_pixel;
uniform int guesses; // 3; a constant would be unrolled
uniform bool is_first;
uniform bool is_newest; // no older picture overrules the newest

const float GAIN = 1.25;       // factor by which a picture must have sampled a place more densely than the one before
const float SETTLED = 1e30;    // nothing can be in front of it
const float LARGEST = 65504.0; // of a half float

float density_of(Ray ray, float depth) {
    return 1.0 / (ray.base_z + depth * ray.parallax_z);
}

bool is_better(float depth, float density, vec2 before) {
    bool alike = abs(depth - before.r) <= depth_tolerance * (max(depth, before.r) + depth_floor);
    return before.r < 0.0 || (alike ? density > GAIN * before.g : depth > before.r);
}

// The keys in the pixel's cell and the eight around it: the nearest, the one in the cell itself,
// and the farthest less 1.
uvec3 keys_around(ivec2 pixel) {
    ivec2 cell = ivec2((vec2(pixel) + 0.5) * cells_per_pixel);
    uvec3 found = uvec3(0u, 0u, 0xFFFFFFFFu);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            ivec2 at = clamp(cell + ivec2(x, y), ivec2(0), cells - 1);
            uint key = seed_of[at.y * cells.x + at.x];
            found = uvec3(max(found.x, key), x == 0 && y == 0 ? key : found.y, min(found.z, key - 1u));
        }
    return found;
}

// Whether the texel is in front of `own` by more than a surface's slope.
bool in_front(ivec2 texel, float own) {
    return held(texel) - own > depth_tolerance * (own + depth_floor);
}

// Where to take the colour of a point: beside a silhouette, whose colour antialiasing has mixed
// into the outermost pixel behind it, half a pixel farther off where that is the same surface. The
// shown pixel beside a silhouette is mixed too: a whole pixel is worse (docs/results-fills.md).
vec2 unmixed(vec2 at) {
    ivec2 texel = ivec2(floor(at));
    float own = held(texel);
    ivec2 away = ivec2(in_front(texel - ivec2(1, 0), own), in_front(texel - ivec2(0, 1), own)) -
                 ivec2(in_front(texel + ivec2(1, 0), own), in_front(texel + ivec2(0, 1), own));
    return of_one_surface(own, held(texel + away)) ? at + 0.5 * vec2(away) : at;
}

void fill(ivec2 pixel, vec3 base, vec2 before) {
    uvec3 keys = keys_around(pixel);
    Ray ray = ray_of(base, e);
    float guess = seed_depth(keys.x);
    bool pending = keys.x != 0u && is_better(guess, density_of(ray, guess), before);
    Meeting found = Meeting(-1.0, vec2(0.0), vec2(0.0), bvec2(false));
    for (int tried = 0; tried < guesses && pending; ++tried) {
        found = meet(ray, guess);
        guess = seed_depth(tried == 0 ? keys.y : keys.z + 1u);
        pending = found.depth < 0.0;
    }
    vec4 sum = textureLod(rendered_colour, unmixed(found.colour_at) * rendered_pixel, 0.0);
    float density = density_of(ray, found.depth);
    bool shows = found.depth >= 0.0 && found.depth <= LARGEST && sum.a >= 0.5 && is_better(found.depth, density, before);
    if (shows) {
        imageStore(filled_colour, pixel, vec4(sum.rgb / sum.a, 1.0));
        imageStore(filled_depth, pixel, vec4(found.depth));
    }
    if (shows || is_first) imageStore(best, pixel, shows ? vec4(is_newest ? SETTLED : found.depth, density, 0.0, 0.0) : vec4(-1.0));
}

vec2 before_at(ivec2 pixel) {
    return is_first ? vec2(-1.0, 0.0) : imageLoad(best, pixel).rg;
}

void main() {
    uint index = gl_GlobalInvocationID.x / uint(PIECE), lane = gl_GlobalInvocationID.x % uint(PIECE);
    if (index >= piece_count) return;
    int piece = int(pieces[index].x), wide = pieces_in_a_row();
    ivec2 first = ivec2(piece % wide * PIECE + int(lane), piece / wide * ROWS);
    if (first.x >= shown_size.x) return;
    vec3 base = H * vec3(vec2(first) + 0.5, 1.0);
    // llvmpipe runs both sides of every `if`, so a loop visits the holes of the column one by one;
    // with its test at the end, as the body also runs where a test before it ends the loop.
    uint left = 0u;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.y >= shown_size.y) break;
        bool open = imageLoad(shown_colour, pixel).a == 0.0 && before_at(pixel).r < SETTLED;
        left |= open ? 1u << row : 0u;
    }
    if (left == 0u) return;
    do {
        int row = findLSB(left);
        ivec2 pixel = first + ivec2(0, row);
        fill(pixel, base + H[1] * float(row), before_at(pixel));
    } while ((left &= left - 1u) != 0u);
}
