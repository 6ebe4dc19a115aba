// One panel, filtered over the footprint of an output pixel. q = (u w, v w, w) of the pixel's centre,
// w the panel's inverse depth there in 1/m; right, up: what q gains from one output pixel to the next.
// The footprint is the ellipse that a round pixel has on the panel (Heckbert 1989, Fundamentals of
// Texture Mapping and Image Warping, 3.5): its long axis is walked by samples, its short one chooses
// the mip level, as anisotropic filters of GPUs do. A picture at its own scale is one bilinear sample.
uniform sampler2D panel; // premultiplied linear light, with mip levels
uniform vec2 panel_texels;

const int MOST_TAPS = 16;

vec4 panel_level(vec2 uv, float level) {
    float low = floor(level);
    vec4 fine = textureLod(panel, uv, low);
    return level > low ? mix(fine, textureLod(panel, uv, low + 1.0), level - low) : fine;
}

// Premultiplied, the share of the pixel that the rectangle covers included; 0 beside it, behind it, and
// within a pixel of its plane's horizon, where a footprint is no ellipse.
vec4 panel_colour(vec3 q, vec3 right, vec3 up) {
    if (!(q.z > abs(right.z) + abs(up.z))) return vec4(0.0);
    vec2 uv = q.xy / q.z;
    vec2 by_x = (right.xy - uv * right.z) / q.z, by_y = (up.xy - uv * up.z) / q.z;
    vec2 wide = max(sqrt(by_x * by_x + by_y * by_y), 1e-12);
    vec2 inside = (min(uv + 0.5 * wide, 1.0) - max(uv - 0.5 * wide, 0.0)) / wide;
    float covered = max(inside.x, 0.0) * max(inside.y, 0.0);
    if (!(covered > 0.0)) return vec4(0.0);
    vec2 x = by_x * panel_texels, y = by_y * panel_texels;
    vec2 square = x * x + y * y;
    float both = dot(vec2(x.x, y.x), vec2(x.y, y.y)), middle = 0.5 * (square.x + square.y);
    float half_difference = 0.5 * (square.x - square.y), away = sqrt(half_difference * half_difference + both * both);
    float major = sqrt(middle + away), minor = sqrt(max(middle - away, 0.0));
    float turn = away > 0.0 ? 0.5 * atan(both, half_difference) : 0.0;
    vec2 along = major * vec2(cos(turn), sin(turn)) / panel_texels;
    int taps = int(clamp(floor(major / max(minor, 1.0) + 0.5), 1.0, float(MOST_TAPS)));
    float level = log2(max(max(minor, major / float(taps)), 1.0));
    vec4 sum = vec4(0.0);
    for (int tap = 0; tap < taps; ++tap)
        sum += panel_level(uv + along * ((float(tap) + 0.5) / float(taps) - 0.5), level);
    return sum * (covered / float(taps));
}
