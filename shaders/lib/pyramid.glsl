// Bounds of the rendered inverse depth in blocks of 4, 16, 64 and 256 texels on each side, levels 1
// to 4, each grown by one texel because surfaces slant towards their neighbours. x: farthest, y:
// nearest; farthest > nearest where a block has no depth.
layout(std430, binding = 0) buffer Pyramid { vec2 bounds_of[]; };
uniform ivec4 level_first, level_width; // of levels 1 to 4: index of the first block, blocks a row
const int TOP = 4;

int block_index(int level, ivec2 block) {
    return level_first[level - 1] + block.y * level_width[level - 1] + block.x;
}
