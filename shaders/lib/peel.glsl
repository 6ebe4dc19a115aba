// The test of a peeling pass: draw only what lies behind the previous layer. Included by the
// fragment stages of the scene and of its background.
uniform sampler2D in_front; // inverse depth of the previous layer; -1: none
uniform float keep;         // a little below 1: a surface is not behind itself

bool behind(float inverse_depth) {
    float before = texelFetch(in_front, ivec2(gl_FragCoord.xy), 0).r;
    return inverse_depth < before * keep;
}
