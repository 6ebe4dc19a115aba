// The window of SSIM: 11 weights of a Gaussian of 1.5 pixels; beyond its border a picture is
// mirrored, as scikit-image has it.
#define RADIUS 5
uniform float bell[2 * RADIUS + 1];

int mirrored_once(int at, int count) {
    at = max(at, -1 - at);
    return min(at, 2 * count - 1 - at);
}

// Twice, which is enough from two pixels on; a division would take longer than the rest.
int mirrored(int at, int count) {
    return max(mirrored_once(mirrored_once(at, count), count), 0);
}
