// Second page of abi.h, which includes it: the scene in device memory, and what cull, estimate and the list of meshlets make
// of it.
#pragma once
#include <stdint.h>

/// Where a box of parameters lies: `Region` in src/scene/trim_tree.rs.
enum Region : uint32_t {
    REGION_INSIDE = 0,
    REGION_OUTSIDE = 1,
    /// A trim curve meets the box.
    REGION_BOUNDARY = 2,
};

/// A face's trim loops: a kd-tree in the lists of all trees. src/scene/trim_tree.rs has the meaning of each.
struct TrimTree {
    /// Lowest and highest (u, v).
    double low[2];
    double high[2];
    /// Largest gap of its curves.
    double gap;
    uint32_t root;
    uint32_t unused;
};

/// `tag` of a node: the axis of a split, or this and above for a cell.
static const uint32_t NODE_CELL = 2;
/// `tag` of a cell: the lower end of its right side is inside. Its number of clips stands above.
static const uint32_t NODE_INSIDE = 1;
static const uint32_t NODE_COUNT_SHIFT = 2;

/// Two children, lower and upper, or a cell with its clips.
struct alignas(16) TrimNode {
    /// Where it is split.
    double at;
    /// First child, or first clip.
    uint32_t first;
    uint32_t tag;
};

/// `exit` of a clip: the height at which it leaves through its cell's right side.
static const uint32_t EXIT_NONE = 0;
static const uint32_t EXIT_LOWER = 1;
static const uint32_t EXIT_UPPER = 2;

/// A segment within one cell, between two heights.
struct TrimClip {
    double heights[2];
    uint32_t segment;
    uint32_t exit;
};

/// A monotone piece of a trim curve, from its lower end to its upper.
struct alignas(16) TrimSegment {
    /// (u, v).
    double ends[2][2];
    double gap;
    /// Its points; none where it is straight.
    uint32_t first;
    uint32_t count;
};

/// (wu, wv, w).
struct TrimPoint {
    double x;
    double y;
    double w;
};

/// One leaf's texture of `--trim texture`: rows of constant v, a bit a texel, in whole words of 32.
struct alignas(16) TrimTexture {
    /// Its first word in the list of all textures' words.
    uint64_t first;
    /// Texels in u and v; none where no loop cuts the leaf.
    uint32_t size[2];
};

/// What the textures are, and what became of the fragments that were looked up.
struct alignas(8) TextureCounts {
    uint64_t tested;
    uint64_t rejected;
    /// Textures that would need more texels a side than they may have.
    uint64_t too_coarse;
};

/// `Bound` in src/stages/options.rs.
enum BoundRule : uint32_t {
    BOUND_SCREEN = 0,
    BOUND_ETER = 1,
    BOUND_FILIP = 2,
    BOUND_PROJECTIVE = 3,
    BOUND_SLEFE = 4,
};

/// `Grid` in src/stages/options.rs.
enum GridRule : uint32_t {
    GRID_ADAPTIVE = 0,
    GRID_VARIABLE = 1,
    GRID_ETER = 2,
    GRID_ETER16 = 3,
};

/// `Cull` in src/stages/options.rs.
enum CullRule : uint32_t {
    CULL_OFF = 0,
    CULL_AUTO = 1,
    CULL_ON = 2,
};

/// `Rules::precision`: the cheapest that fits.
static const uint32_t PRECISION_AUTO = 6;

/// What cull and estimate go by in a frame, besides its `View`.
struct Rules {
    /// A `BoundRule`, a `GridRule`, a `CullRule`.
    uint32_t bound;
    uint32_t grid;
    uint32_t cull;
    /// The near plane cuts nothing open: solids can only be seen from outside.
    uint32_t whole;
    /// An `ArithmeticRule`, or PRECISION_AUTO.
    uint32_t precision;
    /// Only leaves whose grids are cut into large blocks are evaluated on tensor cores.
    uint32_t large_blocks;
    /// What a meshlet costs: in f32 by degree from 1 to 7, in the others.
    double f32_clocks[7];
    double clocks[6];
};

/// A homogeneous control point of the scene: (wx, wy, wz, w) about its patch's origin.
struct alignas(16) ControlPoint {
    double x;
    double y;
    double z;
    double w;
};

/// Which side of a surface can be seen: `Sides` in src/scene/mod.rs.
static const uint32_t SIDES_BOTH = 0;
static const uint32_t SIDES_OUTSIDE = 1;
static const uint32_t SIDES_INSIDE = 2;

/// A patch of the scene: `Patch` in src/scene/mod.rs.
struct alignas(16) ScenePatch {
    /// First of its (degree[0] + 1)(degree[1] + 1) control points, v innermost.
    uint32_t points;
    uint8_t degree[2];
    uint8_t sides;
    uint8_t rational;
    uint32_t face;
    /// Of the face's trims, or NO_TREE.
    uint32_t tree;
    double origin[3];
    double cone_axis[3];
    double cone_cos;
    /// All of it lies so near to its origin.
    double radius;
    /// In the plane of its face's trims: u, v.
    double domain[2][2];
    /// S_uu, S_uv, S_vv.
    double enclosure_low[3][3];
    double enclosure_high[3][3];
    double enclosure_radius[3];
    /// Largest gap of the curves along its borders.
    double gap;
    uint32_t rim;
    uint32_t unused[3];
};

/// An instance: it draws a range of the scene's patches.
struct SceneInstance {
    /// Columns of the linear part.
    double matrix[3][3];
    double translation[3];
    uint32_t first_patch;
    /// The number of its first patch among those of all instances.
    uint32_t first_item;
    /// Colours of single faces, ascending.
    uint32_t first_color;
    uint32_t colors;
    float color[3];
    uint32_t has_color;
};

/// What a face is coloured.
struct FaceColor {
    uint32_t face;
    float color[3];
};

/// One more than the most quads along a side of a leaf: 7 x 7 blocks round 2^12 up.
static const uint32_t BASIS_SIDES = 4103;

/// What becomes of a patch in an instance: `state` of an item.
static const uint32_t ITEM_CULLED = 0;
/// Drawn as a whole.
static const uint32_t ITEM_WHOLE = 1;
/// Drawn in parts, if at all.
static const uint32_t ITEM_SPLIT = 2;

/// A patch that is not culled, and its grid where it is drawn as a whole.
struct alignas(8) Visible {
    uint32_t item;
    uint32_t state;
    uint16_t quads[2];
    uint32_t diagonal;
    float deviation[2];
};

/// What stops a frame, with the item at which it happens.
static const uint32_t ERROR_TOO_MANY_LEAVES = 1;
static const uint32_t ERROR_TOO_CLOSE = 2;
static const uint32_t ERROR_GRID_TOO_LARGE = 3;
static const uint32_t ERROR_TOLERANCE = 4;
static const uint64_t NO_ERROR = 0xffffffffffffffff;

/// What estimate counts.
struct alignas(8) Counters {
    /// The least `item << 8 | error`, or NO_ERROR.
    uint64_t error;
    /// Control points of parts.
    uint64_t part_points;
    /// Patches that are to be split, and how many of them have been taken.
    uint32_t split;
    uint32_t taken;
    /// Leaves that splitting makes; they may be more than there is room for.
    uint32_t parts;
    /// Patches of which something is drawn.
    uint32_t visible;
    /// A warp's list of halves was too short.
    uint32_t short_of_halves;
    uint32_t unused;
};

/// A part of a patch by the halvings that lead to it, the first one in the lowest bit: which way they cut (0: across u) and
/// which half they took (0: the lower one); and its grid.
struct alignas(8) Half {
    uint64_t axes[2];
    uint64_t sides[2];
    uint32_t depth;
    uint32_t diagonal;
    uint32_t quads[2];
    float deviation[2];
};

/// A leaf whose halves are tried: places in a warp's list of halves.
struct HalvedLeaf {
    /// Its halves, and the next one to be looked at.
    uint32_t first;
    uint32_t next;
    uint32_t end;
    /// More halvings that may pass without a gain.
    uint32_t tries;
    /// Quads of its own grid, and of the parts found so far.
    uint32_t quads;
    uint32_t part_quads;
};

/// Where a leaf that splitting made belongs: its visible patch, and its number among the leaves of it.
struct PartPlace {
    uint32_t visible;
    uint32_t number;
    /// First of its control points in the list of parts.
    uint32_t net;
    uint32_t unused;
};

/// What becomes of a block of a leaf's grid: its leaf has no trims; it is looked at; all of it lies outside the trims.
static const uint32_t BLOCK_FREE = 0;
static const uint32_t BLOCK_CUT = 1;
static const uint32_t BLOCK_OUTSIDE = 2;

/// What the meshlet list counts.
struct alignas(8) MeshletCounts {
    uint64_t quads;
    /// Meshlets of trimmed leaves that no curve crosses.
    uint32_t inside;
    /// Those that one may cross.
    uint32_t boundary;
};
