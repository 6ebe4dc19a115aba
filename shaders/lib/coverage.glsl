// Coverage after a warp: 0 in holes, HIDDEN where the lens hides the picture, more where it is known.
// What is hidden is no hole, and nothing is filled from it.
const float HIDDEN = 1.0 / 16384.0; // the least half float that no GPU flushes to 0
