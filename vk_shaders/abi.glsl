// Made of kernels/abi.h by tests/shaders.rs: change that file, and read its comments there.
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

#endif
