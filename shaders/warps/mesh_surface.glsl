// The rendered picture as a surface: one vertex at each pixel centre, cells between four of them,
// numbered 0..w by 0..h from the bottom left. Cell (i, j) lies between the centres of pixels (i-1,
// j-1) and (i, j); those along the border have pixels on one side only and repeat them. Corners of
// a cell: 0 and 1 below, 2 and 3 above. Its joined edges, a bit each: 1 below, 2 above, 4 left, 8
// right.
layout(r32f) readonly uniform image2D rendered_inverse_depth;
uniform ivec2 rendered_size;

const uint ALL_JOINED = 15u;
const float MOST = 1e12; // 1/m; nearer points count as this near, so that nothing overflows

// 1/m, -1 for a pixel without depth; the largest finite float is still a depth.
float known_inverse_depth(ivec2 pixel) {
    float r = imageLoad(rendered_inverse_depth, clamp(pixel, ivec2(0), rendered_size - 1)).r;
    return r >= 0.0 && r <= 3.4028235e38 ? min(r, MOST) : -1.0;
}

struct Block {
    // A bit for each cell that starts a rectangle to draw, 16 bits above it for each that is drawn
    // in pieces
    uint cells;
    // A bit for each joined edge along x, 4 in each of 5 rows; bit 31: part of the block is on
    // screen
    uint rows;
    uint columns;      // and along y, 5 in each of 4 rows
    // Bits of the error as one cell; after mesh_merge: level << 20, pieces before << 10, rectangles
    // before in its group
    uint error_order;
    // Sizes of the rectangles, less one: 2 bits of width and 2 of height for each cell that starts
    // one; the lower 8 cells
    uint sizes_low;
    uint sizes_high;   // and of the upper 8
};
// Cells on a side of a block; its first cell is this times its place, less SHIFT, so that cells 1
// to 16 are a group
const int BLOCK = 4;
const int GROUP = 16; // cells on a side of a group of 16 blocks
const int SHIFT = 15;

ivec2 groups() { return (rendered_size + SHIFT + GROUP) / GROUP; }

ivec2 first_cell(ivec2 block) { return block * BLOCK - SHIFT; }

int group_index(ivec2 group) { return group.y * groups().x + group.x; }

int block_index(ivec2 block) { return block.y * groups().x * (GROUP / BLOCK) + block.x; }
