// What a peeling pass may draw at this pixel: only what lies behind the layer before.
// Included by the fragment stages of the scene and of its background.
uniform sampler2D in_front; // inverse depth of the layer before; -1: there was none
uniform float keep;         // a little below 1: a surface is not behind itself

bool behind(float inverse_depth) {
    float before = texelFetch(in_front, ivec2(gl_FragCoord.xy), 0).r;
    return inverse_depth < before * keep;
}
