// The structs and numbers that host and device share, described here alone. bindgen makes src/cuda/abi.rs of this page
// (HALFPIXEL_UPDATE=1 cargo test --test abi writes it; the test fails while it is stale), with assertions of every size and offset.
//
// Plain C++ that needs no CUDA header, and no pointers: buffers are arguments of kernels. Constants are `static const`,
// since bindgen guesses the types of macros.
#pragma once
#include <stdint.h>

/// Vertices along one side of a meshlet.
static const uint32_t MESHLET_VERTICES = 8;
/// Sub-pixel steps a pixel.
static const int32_t SUBPIXELS = 256;

/// A visibility word: depth bits << 32 | meshlet << INDEX_BITS | index. The larger wins, 0 is background.
static const uint32_t INDEX_BITS = 7;
/// First index of the outer edges of a meshlet: 7 x 7 quads have 98 triangles before them.
static const uint32_t FIRST_EDGE = 98;
/// Outer edges on each of the four sides (u=0, u=1, v=0, v=1).
static const uint32_t EDGES_A_SIDE = 7;
/// A stroke along a fold of the grid: it proposes a pixel and never stays.
static const uint32_t FOLD_INDEX = 127;

/// How cracks between grids are closed: `Fill` in src/stages/options.rs.
enum FillRule : uint32_t {
    FILL_STROKE = 0,
    FILL_ETER = 1,
    FILL_CONSERVATIVE = 2,
    FILL_OFF = 3,
};

/// What a patch is evaluated in: `Arithmetic` in src/cuda/precision.rs.
enum ArithmeticRule : uint32_t {
    ARITHMETIC_F32 = 0,
    ARITHMETIC_F16 = 1,
    ARITHMETIC_F16_RECOVERED = 2,
    ARITHMETIC_F16_SPARSE = 3,
    ARITHMETIC_TF32 = 4,
    ARITHMETIC_TF32_RECOVERED = 5,
};
static const uint32_t ARITHMETICS = 6;

/// A homogeneous point; loaded and stored 16 bytes at a time.
struct alignas(16) Point {
    float x;
    float y;
    float z;
    float w;
};

/// What every kernel knows of the camera: `Lens` in src/stages/lens.rs.
struct View {
    double eye[3];
    /// Rows: right, down, forward.
    double axes[3][3];
    /// Pixels a unit: focal length in perspective, scale in orthographic views.
    double scale;
    /// What is nearer is not drawn.
    double near;
    double extent;
    /// `near` in f32, for depths in perspective.
    float near_f32;
    /// Stored depth lost a unit of camera depth in orthographic views: 1 / extent.
    float depth_slope;
    uint32_t size[2];
    uint32_t perspective;
    /// The interpolation that the bound certifies: 0 affine, 1 projective.
    uint32_t projective;
    /// `Options`: pixels, pixel sizes.
    double tolerance;
    double depth_tolerance;
    /// A `FillRule`.
    uint32_t fill;
    /// Newton steps; 0: interpolated parameters stay as they are.
    uint32_t refine;
    /// Meshlets that trim curves cross are tested.
    uint32_t trim;
    /// A `Show` of src/stages/options.rs.
    uint32_t show;
};

/// A drawn piece of a patch with its grid: `Leaf` and `Tessellation` in src/stages.
struct alignas(16) Patch {
    /// First of its (degree[0] + 1)(degree[1] + 1) control points, v innermost, as (X, Y, Z, w): `Leaf::net`.
    uint32_t net;
    /// First Bernstein value of its grid lines, u and v: degree + 1 values a line, quads + 1 lines.
    uint32_t basis[2];
    uint16_t quads[2];
    uint8_t degree[2];
    /// 0: quads are cut (0,0)-(1,1); 1: (1,0)-(0,1).
    uint8_t diagonal;
    /// Sign of the screen area of triangles that face away on a solid; 0: both sides can be seen.
    int8_t hidden;
    /// Sub-pixel position of its centre from the image's top left corner.
    int32_t base[2];
    float depth_origin;
    /// Orthographic: the stored depth at `depth_origin`.
    float depth_offset;
    /// Bound of the rounding of a vertex's screen position, in pixels.
    float rounding;
    uint32_t instance;
    /// Index into the scene's patches.
    uint32_t source;
};

/// Of a patch without trims, and where trims are off.
static const uint32_t NO_TREE = 0xffffffff;

/// The rest of what is known of a `Patch`, for the stages that draw it; a list of the same order. Pixels unless said.
struct alignas(16) Leaf {
    /// Its rectangle in the source patch's unit square: lower corner, size.
    double corner[2];
    double extent[2];
    /// The same rectangle in the plane of its face's trims; the size may be negative.
    double plane_origin[2];
    double plane_size[2];
    /// What a unit of length covers at most: `pixels_per_unit`.
    double pixels_per_unit;
    /// `Leaf::rounding`.
    double rounding;
    /// The model's gaps as far as they are closed: along the patch's borders, and of all the face's curves.
    double gaps[2];
    /// Parameters that lie in its patch, as far as refinement may go: lower and upper end in u, in v.
    float domain[2][2];
    /// What the grid is off by at most: pixels, and camera depth in model units.
    float deviation[2];
    /// What the depth may change beyond the surface's own slope, model units.
    float depth_tolerance;
    /// Linear RGB.
    float color[3];
    /// `Pen`, sub-pixels: radii for outer edges of sides u=0, u=1, v=0, v=1, where the surface may fold, and along folds.
    int32_t pen_sides[4];
    int32_t pen_radius;
    int32_t pen_fold;
    /// Pixel, about the image centre, that the net is centred on.
    int32_t center[2];
    /// The face's trims, or NO_TREE.
    uint32_t tree;
    /// Weights differ.
    uint16_t rational;
    /// An `ArithmeticRule`.
    uint16_t arithmetic;
};

/// Of a meshlet whose vertices no memory holds.
static const uint32_t NO_VERTICES = 0xffffffff;

/// A block of up to 7 x 7 quads of one patch's grid. 16 bytes: one load (20 cost five).
struct alignas(16) Meshlet {
    uint32_t patch;
    /// First of its (quads[0] + 1)(quads[1] + 1) vertices, v innermost; NO_VERTICES: evaluated where they are wanted.
    uint32_t vertices;
    /// Its first quad in the patch's grid.
    uint16_t first[2];
    uint8_t quads[2];
    /// Which of its sides (u=0, u=1, v=0, v=1) are the patch's, or border on a meshlet that is trimmed away: bits 0 to 3.
    uint8_t outer;
    /// MESHLET_TESTED and MESHLET_ELSEWHERE.
    uint8_t tested;
};
/// A trim curve crosses it.
static const uint32_t MESHLET_TESTED = 1;
/// Mesh shaders draw it.
static const uint32_t MESHLET_ELSEWHERE = 2;

/// A projected vertex, snapped.
struct alignas(16) Vertex {
    /// Sub-pixel position from the image's top left corner.
    int32_t x;
    int32_t y;
    /// Stored depth: larger is nearer, in (0, 1].
    float depth;
    /// Weight of this vertex's parameters at a pixel, as the bound's interpolation asks for.
    float weight;
};

/// A pixel that is not settled yet: the exact surface is asked what it shows.
struct alignas(16) Filled {
    /// What it shows if nothing better is found: a visibility word.
    uint64_t near;
    /// The nearest surface that was found, or 0.
    uint64_t best;
    uint32_t pixel;
    /// Stored depth: only what is nearer counts.
    float behind;
    /// Patch parameters that are known: of `near` before the search (it need not be found again), of `best` after it.
    float start[2];
    uint32_t has_start;
    /// First and number of its candidates.
    uint32_t first;
    uint32_t candidates;
    /// Number of the start that found `best`.
    uint32_t winner;
};

/// What a triangle shows at a pixel, before its trims are asked.
struct alignas(16) Fragment {
    uint64_t word;
    uint32_t pixel;
    uint32_t unused;
};

/// Rows of a large triangle, for a warp of its own.
struct alignas(16) Band {
    uint32_t meshlet;
    /// Index of a triangle in it, or none.
    uint32_t triangle;
    /// The first one.
    uint32_t row;
    uint32_t unused;
};

/// Where the search for a pixel's surface begins.
struct Start {
    /// Patch parameters, before and after.
    float parameters[2];
    /// Its triangle: the lower half of a visibility word.
    uint32_t triangle;
    /// NO_PATCH: there is none.
    uint32_t patch;
    /// Number of its pixel in the list.
    uint32_t slot;
    /// Stored depth that it found; 0: nothing.
    float depth;
};
static const uint32_t NO_PATCH = 0xffffffff;

/// How well the point that a pixel shows is known: `DoubtKind` in src/stages/settle.rs.
static const uint32_t DOUBT_NONE = 0;
/// Under the pixel's centre, but elsewhere in depth.
static const uint32_t DOUBT_DEEP = 1;
/// Not under the centre, or of the inside of a solid.
static const uint32_t DOUBT_BESIDE = 2;
/// Not under the centre, since the patch ends before.
static const uint32_t DOUBT_ENDED = 3;

/// A point of a surface and its unit normal: what ETER's table 1 counts.
struct alignas(8) SurfacePoint {
    float position[3];
    /// Along S_u x S_v; 0 where these are parallel.
    float normal[3];
};

/// A point of a surface with its tangents.
struct alignas(16) SurfaceFrame {
    float position[3];
    /// S_u and S_v of the patch's unit square.
    float along_u[3];
    float along_v[3];
    /// As in `SurfacePoint`.
    float normal[3];
};

/// What a pixel shows: `Pixel` in src/stages/frame.rs. (u, v) are in the source patch's unit square.
struct Shown {
    double interpolated[2];
    double stored[2];
    uint32_t instance;
    uint32_t patch;
};

#include "abi_scene.h"
