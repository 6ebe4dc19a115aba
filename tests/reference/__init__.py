"""Float64 NumPy twins of the shaders, each by another route than the shader's, with the error a
float32 GPU may make.

The shaders multiply pixels by a matrix; the twins follow rays: pixel, direction in the eye, point
in the world, other eye, pixel. Pictures here have their bottom row first, as on the GPU.
"""
