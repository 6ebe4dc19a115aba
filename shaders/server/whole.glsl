// From which share on a sheet counts as a surface that lets nothing pass: half a step of an 8-bit alpha below 1.
// Included by both fragment stages that draw sheets, which must draw the same line.
const float WHOLE = 255.0 / 256.0;
