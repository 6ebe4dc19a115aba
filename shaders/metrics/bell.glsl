// The window of SSIM: 11 weights of a Gaussian of 1.5 pixels; beyond its border a picture is
// mirrored, as scikit-image has it.
#define RADIUS 5
uniform float bell[2 * RADIUS + 1];

int mirrored(int at, int count) {
    int within = (at + 2 * RADIUS * count) % (2 * count);
    return within < count ? within : 2 * count - 1 - within;
}
