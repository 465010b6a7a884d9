// Made of kernels/abi.h and abi_scene.h by tests/shaders.rs: change those, and read their comments there.
#ifndef ABI_GLSL
#define ABI_GLSL
#extension GL_EXT_shader_explicit_arithmetic_types_int8 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int16 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_scalar_block_layout : require

const uint MESHLET_VERTICES = 8u;
const int SUBPIXELS = 256;
const uint INDEX_BITS = 7u;
const uint FIRST_EDGE = 98u;
const uint EDGES_A_SIDE = 7u;
const uint FOLD_INDEX = 127u;
const uint FILL_STROKE = 0u;
const uint FILL_ETER = 1u;
const uint FILL_CONSERVATIVE = 2u;
const uint FILL_OFF = 3u;
const uint ARITHMETIC_F32 = 0u;
const uint ARITHMETIC_F16 = 1u;
const uint ARITHMETIC_F16_RECOVERED = 2u;
const uint ARITHMETIC_F16_SPARSE = 3u;
const uint ARITHMETIC_TF32 = 4u;
const uint ARITHMETIC_TF32_RECOVERED = 5u;
const uint ARITHMETICS = 6u;

struct Point {
    float x;
    float y;
    float z;
    float w;
};

struct View {
    double eye[3];
    double axes[3][3];
    double scale;
    double near;
    double extent;
    float near_f32;
    float depth_slope;
    uint size[2];
    uint perspective;
    uint projective;
    double tolerance;
    double depth_tolerance;
    uint fill;
    uint refine;
    uint trim;
    uint show;
};

struct Patch {
    uint net;
    uint basis[2];
    uint16_t quads[2];
    uint8_t degree[2];
    uint8_t diagonal;
    int8_t hidden;
    int base[2];
    float depth_origin;
    float depth_offset;
    float rounding;
    uint instance;
    uint source;
};

const uint NO_TREE = 0xffffffffu;

struct Leaf {
    double corner[2];
    double extent[2];
    double plane_origin[2];
    double plane_size[2];
    double pixels_per_unit;
    double rounding;
    double gaps[2];
    float domain[2][2];
    float deviation[2];
    float depth_tolerance;
    float color[3];
    int pen_sides[4];
    int pen_radius;
    int pen_fold;
    int center[2];
    uint tree;
    uint16_t rational;
    uint16_t arithmetic;
};

const uint NO_VERTICES = 0xffffffffu;

struct Meshlet {
    uint patch_;
    uint vertices;
    uint16_t first[2];
    uint8_t quads[2];
    uint8_t outer;
    uint8_t tested;
};

const uint MESHLET_TESTED = 1u;
const uint MESHLET_ELSEWHERE = 2u;

struct Vertex {
    int x;
    int y;
    float depth;
    float weight;
};

struct Filled {
    uint64_t near;
    uint64_t best;
    uint pixel;
    float behind;
    float start[2];
    uint has_start;
    uint first;
    uint candidates;
    uint winner;
};

struct Fragment {
    uint64_t word;
    uint pixel;
    uint unused;
};

struct Band {
    uint meshlet;
    uint triangle;
    uint row;
    uint unused;
};

struct Start {
    float parameters[2];
    uint triangle;
    uint patch_;
    uint slot;
    float depth;
};

const uint NO_PATCH = 0xffffffffu;
const uint DOUBT_NONE = 0u;
const uint DOUBT_DEEP = 1u;
const uint DOUBT_BESIDE = 2u;
const uint DOUBT_ENDED = 3u;

struct SurfacePoint {
    float position[3];
    float normal[3];
};

struct SurfaceFrame {
    float position[3];
    float along_u[3];
    float along_v[3];
    float normal[3];
};

struct Shown {
    double interpolated[2];
    double stored[2];
    uint instance;
    uint patch_;
};

const uint REGION_INSIDE = 0u;
const uint REGION_OUTSIDE = 1u;
const uint REGION_BOUNDARY = 2u;

struct TrimTree {
    double low[2];
    double high[2];
    double gap;
    uint root;
    uint unused;
};

const uint NODE_CELL = 2u;
const uint NODE_INSIDE = 1u;
const uint NODE_COUNT_SHIFT = 2u;

struct TrimNode {
    double at;
    uint first;
    uint tag;
};

const uint EXIT_NONE = 0u;
const uint EXIT_LOWER = 1u;
const uint EXIT_UPPER = 2u;

struct TrimClip {
    double heights[2];
    uint segment;
    uint exit;
};

struct TrimSegment {
    double ends[2][2];
    double gap;
    uint first;
    uint count;
};

struct TrimPoint {
    double x;
    double y;
    double w;
};

struct TrimTexture {
    uint64_t first;
    uint size[2];
};

struct TextureCounts {
    uint64_t tested;
    uint64_t rejected;
    uint64_t too_coarse;
};

const uint BOUND_SCREEN = 0u;
const uint BOUND_ETER = 1u;
const uint BOUND_FILIP = 2u;
const uint BOUND_PROJECTIVE = 3u;
const uint BOUND_SLEFE = 4u;
const uint GRID_ADAPTIVE = 0u;
const uint GRID_VARIABLE = 1u;
const uint GRID_ETER = 2u;
const uint GRID_ETER16 = 3u;
const uint CULL_OFF = 0u;
const uint CULL_AUTO = 1u;
const uint CULL_ON = 2u;
const uint PRECISION_AUTO = 6u;

struct Rules {
    uint bound;
    uint grid;
    uint cull;
    uint whole;
    uint precision_;
    uint large_blocks;
    double f32_clocks[7];
    double clocks[6];
};

struct ControlPoint {
    double x;
    double y;
    double z;
    double w;
};

const uint SIDES_BOTH = 0u;
const uint SIDES_OUTSIDE = 1u;
const uint SIDES_INSIDE = 2u;

struct ScenePatch {
    uint points;
    uint8_t degree[2];
    uint8_t sides;
    uint8_t rational;
    uint face;
    uint tree;
    double origin[3];
    double cone_axis[3];
    double cone_cos;
    double radius;
    double domain[2][2];
    double enclosure_low[3][3];
    double enclosure_high[3][3];
    double enclosure_radius[3];
    double gap;
    uint rim;
    uint unused[3];
};

struct SceneInstance {
    double matrix[3][3];
    double translation[3];
    uint first_patch;
    uint first_item;
    uint first_color;
    uint colors;
    float color[3];
    uint has_color;
};

struct FaceColor {
    uint face;
    float color[3];
};

const uint BASIS_SIDES = 4103u;
const uint ITEM_CULLED = 0u;
const uint ITEM_WHOLE = 1u;
const uint ITEM_SPLIT = 2u;

struct Visible {
    uint item;
    uint state;
    uint16_t quads[2];
    uint diagonal;
    float deviation[2];
};

const uint ERROR_TOO_MANY_LEAVES = 1u;
const uint ERROR_TOO_CLOSE = 2u;
const uint ERROR_GRID_TOO_LARGE = 3u;
const uint ERROR_TOLERANCE = 4u;
const uint64_t NO_ERROR = 0xfffffffffffffffful;

struct Counters {
    uint64_t error;
    uint64_t part_points;
    uint split;
    uint taken;
    uint parts;
    uint visible;
    uint short_of_halves;
    uint unused;
};

struct Half {
    uint64_t axes[2];
    uint64_t sides[2];
    uint depth;
    uint diagonal;
    uint quads[2];
    float deviation[2];
};

struct HalvedLeaf {
    uint first;
    uint next;
    uint end;
    uint tries;
    uint quads;
    uint part_quads;
};

struct PartPlace {
    uint visible;
    uint number;
    uint net;
    uint unused;
};

const uint BLOCK_FREE = 0u;
const uint BLOCK_CUT = 1u;
const uint BLOCK_OUTSIDE = 2u;

struct MeshletCounts {
    uint64_t quads;
    uint inside;
    uint boundary;
};

#endif
