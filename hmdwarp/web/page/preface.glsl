#version 300 es
// What WebGL 2 has in place of OpenGL 4.3, before each shader.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
// Beyond its border an image reads 0.
#define is_inside(picture, at) all(equal(clamp(at, ivec2(0), textureSize(picture, 0) - 1), at))
#define imageLoad(picture, at) (is_inside(picture, at) ? texelFetch(picture, at, 0) : vec4(0.0))
