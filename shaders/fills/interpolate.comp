// One 3x3 pass: an empty pixel with at least `minimum_count` covered neighbours takes their median, channel by channel.
// In: shown colour after the warp. Out: shown colour; what has too few covered neighbours stays empty (coverage 0).
// Source: the interpolation step of the 2014 thesis this project starts from.
#include "lib/rows.glsl"
uniform sampler2D warped;
layout(rgba16f) writeonly uniform image2D filled;
uniform ivec2 shown_size;
uniform int minimum_count;

const float FAR_AWAY = 1e30; // sorts after every colour

#define ORDER(a, b) { vec3 low = min(n[a], n[b]); n[b] = max(n[a], n[b]); n[a] = low; }

vec3 at(vec3 n[8], int i) {
    return i < 4 ? (i < 2 ? (i == 0 ? n[0] : n[1]) : (i == 2 ? n[2] : n[3]))
                 : (i < 6 ? (i == 4 ? n[4] : n[5]) : (i == 6 ? n[6] : n[7]));
}

vec4 interpolated(ivec2 p) {
    vec3 n[8];
    int count = 0, k = 0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            if (x == 0 && y == 0) continue;
            ivec2 q = p + ivec2(x, y);
            vec4 c = texelFetch(warped, clamp(q, ivec2(0), shown_size - 1), 0);
            bool covered = c.a > 0.0 && all(greaterThanEqual(q, ivec2(0))) && all(lessThan(q, shown_size));
            n[k++] = covered ? c.rgb : vec3(FAR_AWAY);
            count += int(covered);
        }
    // Batcher's odd-even merge sort of eight, 19 exchanges, no branch.
    ORDER(0, 1) ORDER(2, 3) ORDER(4, 5) ORDER(6, 7)
    ORDER(0, 2) ORDER(1, 3) ORDER(4, 6) ORDER(5, 7)
    ORDER(1, 2) ORDER(5, 6)
    ORDER(0, 4) ORDER(1, 5) ORDER(2, 6) ORDER(3, 7)
    ORDER(2, 4) ORDER(3, 5)
    ORDER(1, 2) ORDER(3, 4) ORDER(5, 6)
    if (count < minimum_count) return vec4(0.0);
    return vec4(0.5 * (at(n, (count - 1) / 2) + at(n, count / 2)), 1.0);
}

void main() {
    ivec2 first = first_pixel();
    if (first.x >= shown_size.x) return;
    for (int row = 0; row < ROWS; ++row) {
        ivec2 p = first + ivec2(0, row);
        if (p.y >= shown_size.y) break;
        vec4 own = texelFetch(warped, p, 0);
        imageStore(filled, p, own.a > 0.0 ? own : interpolated(p));
    }
}
