//! Made by bindgen from kernels/abi.h: change that file, and read its comments there.

/// Vertices along one side of a meshlet.
pub const MESHLET_VERTICES: u32 = 8;
/// Sub-pixel steps a pixel.
pub const SUBPIXELS: i32 = 256;
/// A visibility word: depth bits << 32 | meshlet << INDEX_BITS | index. The larger wins, 0 is background.
pub const INDEX_BITS: u32 = 7;
/// First index of the outer edges of a meshlet: 7 x 7 quads have 98 triangles before them.
pub const FIRST_EDGE: u32 = 98;
/// Outer edges on each of the four sides (u=0, u=1, v=0, v=1).
pub const EDGES_A_SIDE: u32 = 7;
/// A stroke along a fold of the grid: it proposes a pixel and never stays.
pub const FOLD_INDEX: u32 = 127;
pub mod FillRule {
    #[allow(unused_imports)]
    use super::*;
    /// How cracks between grids are closed: `Fill` in src/stages/options.rs.
    pub type Type = u32;
    pub const FILL_STROKE: Type = 0;
    pub const FILL_ETER: Type = 1;
    pub const FILL_CONSERVATIVE: Type = 2;
    pub const FILL_OFF: Type = 3;
}
pub mod ArithmeticRule {
    #[allow(unused_imports)]
    use super::*;
    /// What a patch is evaluated in: `Arithmetic` in src/cuda/precision.rs.
    pub type Type = u32;
    pub const ARITHMETIC_F32: Type = 0;
    pub const ARITHMETIC_F16: Type = 1;
    pub const ARITHMETIC_F16_RECOVERED: Type = 2;
    pub const ARITHMETIC_F16_SPARSE: Type = 3;
    pub const ARITHMETIC_TF32: Type = 4;
    pub const ARITHMETIC_TF32_RECOVERED: Type = 5;
}
pub const ARITHMETICS: u32 = 6;
/// A homogeneous point; loaded and stored 16 bytes at a time.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Point {
    pub x: f32,
    pub y: f32,
    pub z: f32,
    pub w: f32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Point"][::core::mem::size_of::<Point>() - 16usize];
    ["Alignment of Point"][::core::mem::align_of::<Point>() - 16usize];
    ["Offset of field: Point::x"][::core::mem::offset_of!(Point, x) - 0usize];
    ["Offset of field: Point::y"][::core::mem::offset_of!(Point, y) - 4usize];
    ["Offset of field: Point::z"][::core::mem::offset_of!(Point, z) - 8usize];
    ["Offset of field: Point::w"][::core::mem::offset_of!(Point, w) - 12usize];
};
/// What every kernel knows of the camera: `Lens` in src/stages/lens.rs.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct View {
    pub eye: [f64; 3usize],
    /// Rows: right, down, forward.
    pub axes: [[f64; 3usize]; 3usize],
    /// Pixels a unit: focal length in perspective, scale in orthographic views.
    pub scale: f64,
    /// What is nearer is not drawn.
    pub near: f64,
    pub extent: f64,
    /// `near` in f32, for depths in perspective.
    pub near_f32: f32,
    /// Stored depth lost a unit of camera depth in orthographic views: 1 / extent.
    pub depth_slope: f32,
    pub size: [u32; 2usize],
    pub perspective: u32,
    /// The interpolation that the bound certifies: 0 affine, 1 projective.
    pub projective: u32,
    /// `Options`: pixels, pixel sizes.
    pub tolerance: f64,
    pub depth_tolerance: f64,
    /// A `FillRule`.
    pub fill: u32,
    /// Newton steps; 0: interpolated parameters stay as they are.
    pub refine: u32,
    /// Meshlets that trim curves cross are tested.
    pub trim: u32,
    /// A `Show` of src/stages/options.rs.
    pub show: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of View"][::core::mem::size_of::<View>() - 176usize];
    ["Alignment of View"][::core::mem::align_of::<View>() - 8usize];
    ["Offset of field: View::eye"][::core::mem::offset_of!(View, eye) - 0usize];
    ["Offset of field: View::axes"][::core::mem::offset_of!(View, axes) - 24usize];
    ["Offset of field: View::scale"][::core::mem::offset_of!(View, scale) - 96usize];
    ["Offset of field: View::near"][::core::mem::offset_of!(View, near) - 104usize];
    ["Offset of field: View::extent"][::core::mem::offset_of!(View, extent) - 112usize];
    [
        "Offset of field: View::near_f32",
    ][::core::mem::offset_of!(View, near_f32) - 120usize];
    [
        "Offset of field: View::depth_slope",
    ][::core::mem::offset_of!(View, depth_slope) - 124usize];
    ["Offset of field: View::size"][::core::mem::offset_of!(View, size) - 128usize];
    [
        "Offset of field: View::perspective",
    ][::core::mem::offset_of!(View, perspective) - 136usize];
    [
        "Offset of field: View::projective",
    ][::core::mem::offset_of!(View, projective) - 140usize];
    [
        "Offset of field: View::tolerance",
    ][::core::mem::offset_of!(View, tolerance) - 144usize];
    [
        "Offset of field: View::depth_tolerance",
    ][::core::mem::offset_of!(View, depth_tolerance) - 152usize];
    ["Offset of field: View::fill"][::core::mem::offset_of!(View, fill) - 160usize];
    ["Offset of field: View::refine"][::core::mem::offset_of!(View, refine) - 164usize];
    ["Offset of field: View::trim"][::core::mem::offset_of!(View, trim) - 168usize];
    ["Offset of field: View::show"][::core::mem::offset_of!(View, show) - 172usize];
};
/// A drawn piece of a patch with its grid: `Leaf` and `Tessellation` in src/stages.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Patch {
    /// First of its (degree[0] + 1)(degree[1] + 1) control points, v innermost, as (X, Y, Z, w): `Leaf::net`.
    pub net: u32,
    /// First Bernstein value of its grid lines, u and v: degree + 1 values a line, quads + 1 lines.
    pub basis: [u32; 2usize],
    pub quads: [u16; 2usize],
    pub degree: [u8; 2usize],
    /// 0: quads are cut (0,0)-(1,1); 1: (1,0)-(0,1).
    pub diagonal: u8,
    /// Sign of the screen area of triangles that face away on a solid; 0: both sides can be seen.
    pub hidden: i8,
    /// Sub-pixel position of its centre from the image's top left corner.
    pub base: [i32; 2usize],
    pub depth_origin: f32,
    /// Orthographic: the stored depth at `depth_origin`.
    pub depth_offset: f32,
    /// Bound of the rounding of a vertex's screen position, in pixels.
    pub rounding: f32,
    pub instance: u32,
    /// Index into the scene's patches.
    pub source: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Patch"][::core::mem::size_of::<Patch>() - 48usize];
    ["Alignment of Patch"][::core::mem::align_of::<Patch>() - 16usize];
    ["Offset of field: Patch::net"][::core::mem::offset_of!(Patch, net) - 0usize];
    ["Offset of field: Patch::basis"][::core::mem::offset_of!(Patch, basis) - 4usize];
    ["Offset of field: Patch::quads"][::core::mem::offset_of!(Patch, quads) - 12usize];
    ["Offset of field: Patch::degree"][::core::mem::offset_of!(Patch, degree) - 16usize];
    [
        "Offset of field: Patch::diagonal",
    ][::core::mem::offset_of!(Patch, diagonal) - 18usize];
    ["Offset of field: Patch::hidden"][::core::mem::offset_of!(Patch, hidden) - 19usize];
    ["Offset of field: Patch::base"][::core::mem::offset_of!(Patch, base) - 20usize];
    [
        "Offset of field: Patch::depth_origin",
    ][::core::mem::offset_of!(Patch, depth_origin) - 28usize];
    [
        "Offset of field: Patch::depth_offset",
    ][::core::mem::offset_of!(Patch, depth_offset) - 32usize];
    [
        "Offset of field: Patch::rounding",
    ][::core::mem::offset_of!(Patch, rounding) - 36usize];
    [
        "Offset of field: Patch::instance",
    ][::core::mem::offset_of!(Patch, instance) - 40usize];
    ["Offset of field: Patch::source"][::core::mem::offset_of!(Patch, source) - 44usize];
};
/// Of a patch without trims, and where trims are off.
pub const NO_TREE: u32 = 4294967295;
/// The rest of what is known of a `Patch`, for the stages that draw it; a list of the same order. Pixels unless said.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Leaf {
    /// Its rectangle in the source patch's unit square: lower corner, size.
    pub corner: [f64; 2usize],
    pub extent: [f64; 2usize],
    /// The same rectangle in the plane of its face's trims; the size may be negative.
    pub plane_origin: [f64; 2usize],
    pub plane_size: [f64; 2usize],
    /// What a unit of length covers at most: `pixels_per_unit`.
    pub pixels_per_unit: f64,
    /// `Leaf::rounding`.
    pub rounding: f64,
    /// The model's gaps as far as they are closed: along the patch's borders, and of all the face's curves.
    pub gaps: [f64; 2usize],
    /// Parameters that lie in its patch, as far as refinement may go: lower and upper end in u, in v.
    pub domain: [[f32; 2usize]; 2usize],
    /// What the grid is off by at most: pixels, and camera depth in model units.
    pub deviation: [f32; 2usize],
    /// What the depth may change beyond the surface's own slope, model units.
    pub depth_tolerance: f32,
    /// Linear RGB.
    pub color: [f32; 3usize],
    /// `Pen`, sub-pixels: radii for outer edges of sides u=0, u=1, v=0, v=1, where the surface may fold, and along folds.
    pub pen_sides: [i32; 4usize],
    pub pen_radius: i32,
    pub pen_fold: i32,
    /// Pixel, about the image centre, that the net is centred on.
    pub center: [i32; 2usize],
    /// The face's trims, or NO_TREE.
    pub tree: u32,
    /// Weights differ.
    pub rational: u16,
    /// An `ArithmeticRule`.
    pub arithmetic: u16,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Leaf"][::core::mem::size_of::<Leaf>() - 176usize];
    ["Alignment of Leaf"][::core::mem::align_of::<Leaf>() - 16usize];
    ["Offset of field: Leaf::corner"][::core::mem::offset_of!(Leaf, corner) - 0usize];
    ["Offset of field: Leaf::extent"][::core::mem::offset_of!(Leaf, extent) - 16usize];
    [
        "Offset of field: Leaf::plane_origin",
    ][::core::mem::offset_of!(Leaf, plane_origin) - 32usize];
    [
        "Offset of field: Leaf::plane_size",
    ][::core::mem::offset_of!(Leaf, plane_size) - 48usize];
    [
        "Offset of field: Leaf::pixels_per_unit",
    ][::core::mem::offset_of!(Leaf, pixels_per_unit) - 64usize];
    [
        "Offset of field: Leaf::rounding",
    ][::core::mem::offset_of!(Leaf, rounding) - 72usize];
    ["Offset of field: Leaf::gaps"][::core::mem::offset_of!(Leaf, gaps) - 80usize];
    ["Offset of field: Leaf::domain"][::core::mem::offset_of!(Leaf, domain) - 96usize];
    [
        "Offset of field: Leaf::deviation",
    ][::core::mem::offset_of!(Leaf, deviation) - 112usize];
    [
        "Offset of field: Leaf::depth_tolerance",
    ][::core::mem::offset_of!(Leaf, depth_tolerance) - 120usize];
    ["Offset of field: Leaf::color"][::core::mem::offset_of!(Leaf, color) - 124usize];
    [
        "Offset of field: Leaf::pen_sides",
    ][::core::mem::offset_of!(Leaf, pen_sides) - 136usize];
    [
        "Offset of field: Leaf::pen_radius",
    ][::core::mem::offset_of!(Leaf, pen_radius) - 152usize];
    [
        "Offset of field: Leaf::pen_fold",
    ][::core::mem::offset_of!(Leaf, pen_fold) - 156usize];
    ["Offset of field: Leaf::center"][::core::mem::offset_of!(Leaf, center) - 160usize];
    ["Offset of field: Leaf::tree"][::core::mem::offset_of!(Leaf, tree) - 168usize];
    [
        "Offset of field: Leaf::rational",
    ][::core::mem::offset_of!(Leaf, rational) - 172usize];
    [
        "Offset of field: Leaf::arithmetic",
    ][::core::mem::offset_of!(Leaf, arithmetic) - 174usize];
};
/// Of a meshlet whose vertices no memory holds.
pub const NO_VERTICES: u32 = 4294967295;
/// A block of up to 7 x 7 quads of one patch's grid. 16 bytes: one load (20 cost five).
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Meshlet {
    pub patch: u32,
    /// First of its (quads[0] + 1)(quads[1] + 1) vertices, v innermost; NO_VERTICES: evaluated where they are wanted.
    pub vertices: u32,
    /// Its first quad in the patch's grid.
    pub first: [u16; 2usize],
    pub quads: [u8; 2usize],
    /// Which of its sides (u=0, u=1, v=0, v=1) are the patch's, or border on a meshlet that is trimmed away: bits 0 to 3.
    pub outer: u8,
    /// MESHLET_TESTED and MESHLET_ELSEWHERE.
    pub tested: u8,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Meshlet"][::core::mem::size_of::<Meshlet>() - 16usize];
    ["Alignment of Meshlet"][::core::mem::align_of::<Meshlet>() - 16usize];
    [
        "Offset of field: Meshlet::patch",
    ][::core::mem::offset_of!(Meshlet, patch) - 0usize];
    [
        "Offset of field: Meshlet::vertices",
    ][::core::mem::offset_of!(Meshlet, vertices) - 4usize];
    [
        "Offset of field: Meshlet::first",
    ][::core::mem::offset_of!(Meshlet, first) - 8usize];
    [
        "Offset of field: Meshlet::quads",
    ][::core::mem::offset_of!(Meshlet, quads) - 12usize];
    [
        "Offset of field: Meshlet::outer",
    ][::core::mem::offset_of!(Meshlet, outer) - 14usize];
    [
        "Offset of field: Meshlet::tested",
    ][::core::mem::offset_of!(Meshlet, tested) - 15usize];
};
/// A trim curve crosses it.
pub const MESHLET_TESTED: u32 = 1;
/// Mesh shaders draw it.
pub const MESHLET_ELSEWHERE: u32 = 2;
/// A projected vertex, snapped.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Vertex {
    /// Sub-pixel position from the image's top left corner.
    pub x: i32,
    pub y: i32,
    /// Stored depth: larger is nearer, in (0, 1].
    pub depth: f32,
    /// Weight of this vertex's parameters at a pixel, as the bound's interpolation asks for.
    pub weight: f32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Vertex"][::core::mem::size_of::<Vertex>() - 16usize];
    ["Alignment of Vertex"][::core::mem::align_of::<Vertex>() - 16usize];
    ["Offset of field: Vertex::x"][::core::mem::offset_of!(Vertex, x) - 0usize];
    ["Offset of field: Vertex::y"][::core::mem::offset_of!(Vertex, y) - 4usize];
    ["Offset of field: Vertex::depth"][::core::mem::offset_of!(Vertex, depth) - 8usize];
    [
        "Offset of field: Vertex::weight",
    ][::core::mem::offset_of!(Vertex, weight) - 12usize];
};
/// A pixel that is not settled yet: the exact surface is asked what it shows.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Filled {
    /// What it shows if nothing better is found: a visibility word.
    pub near: u64,
    /// The nearest surface that was found, or 0.
    pub best: u64,
    pub pixel: u32,
    /// Stored depth: only what is nearer counts.
    pub behind: f32,
    /// Patch parameters that are known: of `near` before the search (it need not be found again), of `best` after it.
    pub start: [f32; 2usize],
    pub has_start: u32,
    /// First and number of its candidates.
    pub first: u32,
    pub candidates: u32,
    /// Number of the start that found `best`.
    pub winner: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Filled"][::core::mem::size_of::<Filled>() - 48usize];
    ["Alignment of Filled"][::core::mem::align_of::<Filled>() - 16usize];
    ["Offset of field: Filled::near"][::core::mem::offset_of!(Filled, near) - 0usize];
    ["Offset of field: Filled::best"][::core::mem::offset_of!(Filled, best) - 8usize];
    ["Offset of field: Filled::pixel"][::core::mem::offset_of!(Filled, pixel) - 16usize];
    [
        "Offset of field: Filled::behind",
    ][::core::mem::offset_of!(Filled, behind) - 20usize];
    ["Offset of field: Filled::start"][::core::mem::offset_of!(Filled, start) - 24usize];
    [
        "Offset of field: Filled::has_start",
    ][::core::mem::offset_of!(Filled, has_start) - 32usize];
    ["Offset of field: Filled::first"][::core::mem::offset_of!(Filled, first) - 36usize];
    [
        "Offset of field: Filled::candidates",
    ][::core::mem::offset_of!(Filled, candidates) - 40usize];
    [
        "Offset of field: Filled::winner",
    ][::core::mem::offset_of!(Filled, winner) - 44usize];
};
/// What a triangle shows at a pixel, before its trims are asked.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Fragment {
    pub word: u64,
    pub pixel: u32,
    pub unused: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Fragment"][::core::mem::size_of::<Fragment>() - 16usize];
    ["Alignment of Fragment"][::core::mem::align_of::<Fragment>() - 16usize];
    [
        "Offset of field: Fragment::word",
    ][::core::mem::offset_of!(Fragment, word) - 0usize];
    [
        "Offset of field: Fragment::pixel",
    ][::core::mem::offset_of!(Fragment, pixel) - 8usize];
    [
        "Offset of field: Fragment::unused",
    ][::core::mem::offset_of!(Fragment, unused) - 12usize];
};
/// Rows of a large triangle, for a warp of its own.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Band {
    pub meshlet: u32,
    /// Index of a triangle in it, or none.
    pub triangle: u32,
    /// The first one.
    pub row: u32,
    pub unused: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Band"][::core::mem::size_of::<Band>() - 16usize];
    ["Alignment of Band"][::core::mem::align_of::<Band>() - 16usize];
    ["Offset of field: Band::meshlet"][::core::mem::offset_of!(Band, meshlet) - 0usize];
    [
        "Offset of field: Band::triangle",
    ][::core::mem::offset_of!(Band, triangle) - 4usize];
    ["Offset of field: Band::row"][::core::mem::offset_of!(Band, row) - 8usize];
    ["Offset of field: Band::unused"][::core::mem::offset_of!(Band, unused) - 12usize];
};
/// Where the search for a pixel's surface begins.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Start {
    /// Patch parameters, before and after.
    pub parameters: [f32; 2usize],
    /// Its triangle: the lower half of a visibility word.
    pub triangle: u32,
    /// NO_PATCH: there is none.
    pub patch: u32,
    /// Number of its pixel in the list.
    pub slot: u32,
    /// Stored depth that it found; 0: nothing.
    pub depth: f32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Start"][::core::mem::size_of::<Start>() - 24usize];
    ["Alignment of Start"][::core::mem::align_of::<Start>() - 4usize];
    [
        "Offset of field: Start::parameters",
    ][::core::mem::offset_of!(Start, parameters) - 0usize];
    [
        "Offset of field: Start::triangle",
    ][::core::mem::offset_of!(Start, triangle) - 8usize];
    ["Offset of field: Start::patch"][::core::mem::offset_of!(Start, patch) - 12usize];
    ["Offset of field: Start::slot"][::core::mem::offset_of!(Start, slot) - 16usize];
    ["Offset of field: Start::depth"][::core::mem::offset_of!(Start, depth) - 20usize];
};
pub const NO_PATCH: u32 = 4294967295;
/// How well the point that a pixel shows is known: `DoubtKind` in src/stages/settle.rs.
pub const DOUBT_NONE: u32 = 0;
/// Under the pixel's centre, but elsewhere in depth.
pub const DOUBT_DEEP: u32 = 1;
/// Not under the centre, or of the inside of a solid.
pub const DOUBT_BESIDE: u32 = 2;
/// Not under the centre, since the patch ends before.
pub const DOUBT_ENDED: u32 = 3;
/// A point of a surface and its unit normal: what ETER's table 1 counts.
#[repr(C)]
#[repr(align(8))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct SurfacePoint {
    pub position: [f32; 3usize],
    /// Along S_u x S_v; 0 where these are parallel.
    pub normal: [f32; 3usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of SurfacePoint"][::core::mem::size_of::<SurfacePoint>() - 24usize];
    ["Alignment of SurfacePoint"][::core::mem::align_of::<SurfacePoint>() - 8usize];
    [
        "Offset of field: SurfacePoint::position",
    ][::core::mem::offset_of!(SurfacePoint, position) - 0usize];
    [
        "Offset of field: SurfacePoint::normal",
    ][::core::mem::offset_of!(SurfacePoint, normal) - 12usize];
};
/// A point of a surface with its tangents.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct SurfaceFrame {
    pub position: [f32; 3usize],
    /// S_u and S_v of the patch's unit square.
    pub along_u: [f32; 3usize],
    pub along_v: [f32; 3usize],
    /// As in `SurfacePoint`.
    pub normal: [f32; 3usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of SurfaceFrame"][::core::mem::size_of::<SurfaceFrame>() - 48usize];
    ["Alignment of SurfaceFrame"][::core::mem::align_of::<SurfaceFrame>() - 16usize];
    [
        "Offset of field: SurfaceFrame::position",
    ][::core::mem::offset_of!(SurfaceFrame, position) - 0usize];
    [
        "Offset of field: SurfaceFrame::along_u",
    ][::core::mem::offset_of!(SurfaceFrame, along_u) - 12usize];
    [
        "Offset of field: SurfaceFrame::along_v",
    ][::core::mem::offset_of!(SurfaceFrame, along_v) - 24usize];
    [
        "Offset of field: SurfaceFrame::normal",
    ][::core::mem::offset_of!(SurfaceFrame, normal) - 36usize];
};
/// What a pixel shows: `Pixel` in src/stages/frame.rs. (u, v) are in the source patch's unit square.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Shown {
    pub interpolated: [f64; 2usize],
    pub stored: [f64; 2usize],
    pub instance: u32,
    pub patch: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Shown"][::core::mem::size_of::<Shown>() - 40usize];
    ["Alignment of Shown"][::core::mem::align_of::<Shown>() - 8usize];
    [
        "Offset of field: Shown::interpolated",
    ][::core::mem::offset_of!(Shown, interpolated) - 0usize];
    ["Offset of field: Shown::stored"][::core::mem::offset_of!(Shown, stored) - 16usize];
    [
        "Offset of field: Shown::instance",
    ][::core::mem::offset_of!(Shown, instance) - 32usize];
    ["Offset of field: Shown::patch"][::core::mem::offset_of!(Shown, patch) - 36usize];
};
pub mod Region {
    #[allow(unused_imports)]
    use super::*;
    /// Where a box of parameters lies: `Region` in src/scene/trim_tree.rs.
    pub type Type = u32;
    pub const REGION_INSIDE: Type = 0;
    pub const REGION_OUTSIDE: Type = 1;
    /// A trim curve meets the box.
    pub const REGION_BOUNDARY: Type = 2;
}
/// A face's trim loops: a kd-tree in the lists of all trees. src/scene/trim_tree.rs has the meaning of each.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct TrimTree {
    /// Lowest and highest (u, v).
    pub low: [f64; 2usize],
    pub high: [f64; 2usize],
    /// Largest gap of its curves.
    pub gap: f64,
    pub root: u32,
    pub unused: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of TrimTree"][::core::mem::size_of::<TrimTree>() - 48usize];
    ["Alignment of TrimTree"][::core::mem::align_of::<TrimTree>() - 8usize];
    ["Offset of field: TrimTree::low"][::core::mem::offset_of!(TrimTree, low) - 0usize];
    [
        "Offset of field: TrimTree::high",
    ][::core::mem::offset_of!(TrimTree, high) - 16usize];
    ["Offset of field: TrimTree::gap"][::core::mem::offset_of!(TrimTree, gap) - 32usize];
    [
        "Offset of field: TrimTree::root",
    ][::core::mem::offset_of!(TrimTree, root) - 40usize];
    [
        "Offset of field: TrimTree::unused",
    ][::core::mem::offset_of!(TrimTree, unused) - 44usize];
};
/// `tag` of a node: the axis of a split, or this and above for a cell.
pub const NODE_CELL: u32 = 2;
/// `tag` of a cell: the lower end of its right side is inside. Its number of clips stands above.
pub const NODE_INSIDE: u32 = 1;
pub const NODE_COUNT_SHIFT: u32 = 2;
/// Two children, lower and upper, or a cell with its clips.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct TrimNode {
    /// Where it is split.
    pub at: f64,
    /// First child, or first clip.
    pub first: u32,
    pub tag: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of TrimNode"][::core::mem::size_of::<TrimNode>() - 16usize];
    ["Alignment of TrimNode"][::core::mem::align_of::<TrimNode>() - 16usize];
    ["Offset of field: TrimNode::at"][::core::mem::offset_of!(TrimNode, at) - 0usize];
    [
        "Offset of field: TrimNode::first",
    ][::core::mem::offset_of!(TrimNode, first) - 8usize];
    ["Offset of field: TrimNode::tag"][::core::mem::offset_of!(TrimNode, tag) - 12usize];
};
/// `exit` of a clip: the height at which it leaves through its cell's right side.
pub const EXIT_NONE: u32 = 0;
pub const EXIT_LOWER: u32 = 1;
pub const EXIT_UPPER: u32 = 2;
/// A segment within one cell, between two heights.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct TrimClip {
    pub heights: [f64; 2usize],
    pub segment: u32,
    pub exit: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of TrimClip"][::core::mem::size_of::<TrimClip>() - 24usize];
    ["Alignment of TrimClip"][::core::mem::align_of::<TrimClip>() - 8usize];
    [
        "Offset of field: TrimClip::heights",
    ][::core::mem::offset_of!(TrimClip, heights) - 0usize];
    [
        "Offset of field: TrimClip::segment",
    ][::core::mem::offset_of!(TrimClip, segment) - 16usize];
    [
        "Offset of field: TrimClip::exit",
    ][::core::mem::offset_of!(TrimClip, exit) - 20usize];
};
/// A monotone piece of a trim curve, from its lower end to its upper.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct TrimSegment {
    /// (u, v).
    pub ends: [[f64; 2usize]; 2usize],
    pub gap: f64,
    /// Its points; none where it is straight.
    pub first: u32,
    pub count: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of TrimSegment"][::core::mem::size_of::<TrimSegment>() - 48usize];
    ["Alignment of TrimSegment"][::core::mem::align_of::<TrimSegment>() - 16usize];
    [
        "Offset of field: TrimSegment::ends",
    ][::core::mem::offset_of!(TrimSegment, ends) - 0usize];
    [
        "Offset of field: TrimSegment::gap",
    ][::core::mem::offset_of!(TrimSegment, gap) - 32usize];
    [
        "Offset of field: TrimSegment::first",
    ][::core::mem::offset_of!(TrimSegment, first) - 40usize];
    [
        "Offset of field: TrimSegment::count",
    ][::core::mem::offset_of!(TrimSegment, count) - 44usize];
};
/// (wu, wv, w).
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct TrimPoint {
    pub x: f64,
    pub y: f64,
    pub w: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of TrimPoint"][::core::mem::size_of::<TrimPoint>() - 24usize];
    ["Alignment of TrimPoint"][::core::mem::align_of::<TrimPoint>() - 8usize];
    ["Offset of field: TrimPoint::x"][::core::mem::offset_of!(TrimPoint, x) - 0usize];
    ["Offset of field: TrimPoint::y"][::core::mem::offset_of!(TrimPoint, y) - 8usize];
    ["Offset of field: TrimPoint::w"][::core::mem::offset_of!(TrimPoint, w) - 16usize];
};
/// One leaf's texture of `--trim texture`: rows of constant v, a bit a texel, in whole words of 32.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct TrimTexture {
    /// Its first word in the list of all textures' words.
    pub first: u64,
    /// Texels in u and v; none where no loop cuts the leaf.
    pub size: [u32; 2usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of TrimTexture"][::core::mem::size_of::<TrimTexture>() - 16usize];
    ["Alignment of TrimTexture"][::core::mem::align_of::<TrimTexture>() - 16usize];
    [
        "Offset of field: TrimTexture::first",
    ][::core::mem::offset_of!(TrimTexture, first) - 0usize];
    [
        "Offset of field: TrimTexture::size",
    ][::core::mem::offset_of!(TrimTexture, size) - 8usize];
};
/// What the textures are, and what became of the fragments that were looked up.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct TextureCounts {
    pub tested: u64,
    pub rejected: u64,
    /// Textures that would need more texels a side than they may have.
    pub too_coarse: u64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of TextureCounts"][::core::mem::size_of::<TextureCounts>() - 24usize];
    ["Alignment of TextureCounts"][::core::mem::align_of::<TextureCounts>() - 8usize];
    [
        "Offset of field: TextureCounts::tested",
    ][::core::mem::offset_of!(TextureCounts, tested) - 0usize];
    [
        "Offset of field: TextureCounts::rejected",
    ][::core::mem::offset_of!(TextureCounts, rejected) - 8usize];
    [
        "Offset of field: TextureCounts::too_coarse",
    ][::core::mem::offset_of!(TextureCounts, too_coarse) - 16usize];
};
pub mod BoundRule {
    #[allow(unused_imports)]
    use super::*;
    /// `Bound` in src/stages/options.rs.
    pub type Type = u32;
    pub const BOUND_SCREEN: Type = 0;
    pub const BOUND_ETER: Type = 1;
    pub const BOUND_FILIP: Type = 2;
    pub const BOUND_PROJECTIVE: Type = 3;
    pub const BOUND_SLEFE: Type = 4;
}
pub mod GridRule {
    #[allow(unused_imports)]
    use super::*;
    /// `Grid` in src/stages/options.rs.
    pub type Type = u32;
    pub const GRID_ADAPTIVE: Type = 0;
    pub const GRID_VARIABLE: Type = 1;
    pub const GRID_ETER: Type = 2;
    pub const GRID_ETER16: Type = 3;
}
pub mod CullRule {
    #[allow(unused_imports)]
    use super::*;
    /// `Cull` in src/stages/options.rs.
    pub type Type = u32;
    pub const CULL_OFF: Type = 0;
    pub const CULL_AUTO: Type = 1;
    pub const CULL_ON: Type = 2;
}
/// `Rules::precision`: the cheapest that fits.
pub const PRECISION_AUTO: u32 = 6;
/// What cull and estimate go by in a frame, besides its `View`.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Rules {
    /// A `BoundRule`, a `GridRule`, a `CullRule`.
    pub bound: u32,
    pub grid: u32,
    pub cull: u32,
    /// The near plane cuts nothing open: solids can only be seen from outside.
    pub whole: u32,
    /// An `ArithmeticRule`, or PRECISION_AUTO.
    pub precision: u32,
    /// Only leaves whose grids are cut into large blocks are evaluated on tensor cores.
    pub large_blocks: u32,
    /// What a meshlet costs: in f32 by degree from 1 to 7, in the others.
    pub f32_clocks: [f64; 7usize],
    pub clocks: [f64; 6usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Rules"][::core::mem::size_of::<Rules>() - 128usize];
    ["Alignment of Rules"][::core::mem::align_of::<Rules>() - 8usize];
    ["Offset of field: Rules::bound"][::core::mem::offset_of!(Rules, bound) - 0usize];
    ["Offset of field: Rules::grid"][::core::mem::offset_of!(Rules, grid) - 4usize];
    ["Offset of field: Rules::cull"][::core::mem::offset_of!(Rules, cull) - 8usize];
    ["Offset of field: Rules::whole"][::core::mem::offset_of!(Rules, whole) - 12usize];
    [
        "Offset of field: Rules::precision",
    ][::core::mem::offset_of!(Rules, precision) - 16usize];
    [
        "Offset of field: Rules::large_blocks",
    ][::core::mem::offset_of!(Rules, large_blocks) - 20usize];
    [
        "Offset of field: Rules::f32_clocks",
    ][::core::mem::offset_of!(Rules, f32_clocks) - 24usize];
    ["Offset of field: Rules::clocks"][::core::mem::offset_of!(Rules, clocks) - 80usize];
};
/// A homogeneous control point of the scene: (wx, wy, wz, w) about its patch's origin.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct ControlPoint {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of ControlPoint"][::core::mem::size_of::<ControlPoint>() - 32usize];
    ["Alignment of ControlPoint"][::core::mem::align_of::<ControlPoint>() - 16usize];
    [
        "Offset of field: ControlPoint::x",
    ][::core::mem::offset_of!(ControlPoint, x) - 0usize];
    [
        "Offset of field: ControlPoint::y",
    ][::core::mem::offset_of!(ControlPoint, y) - 8usize];
    [
        "Offset of field: ControlPoint::z",
    ][::core::mem::offset_of!(ControlPoint, z) - 16usize];
    [
        "Offset of field: ControlPoint::w",
    ][::core::mem::offset_of!(ControlPoint, w) - 24usize];
};
/// Which side of a surface can be seen: `Sides` in src/scene/mod.rs.
pub const SIDES_BOTH: u32 = 0;
pub const SIDES_OUTSIDE: u32 = 1;
pub const SIDES_INSIDE: u32 = 2;
/// A patch of the scene: `Patch` in src/scene/mod.rs.
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct ScenePatch {
    /// First of its (degree[0] + 1)(degree[1] + 1) control points, v innermost.
    pub points: u32,
    pub degree: [u8; 2usize],
    pub sides: u8,
    pub rational: u8,
    pub face: u32,
    /// Of the face's trims, or NO_TREE.
    pub tree: u32,
    pub origin: [f64; 3usize],
    pub cone_axis: [f64; 3usize],
    pub cone_cos: f64,
    /// All of it lies so near to its origin.
    pub radius: f64,
    /// In the plane of its face's trims: u, v.
    pub domain: [[f64; 2usize]; 2usize],
    /// S_uu, S_uv, S_vv.
    pub enclosure_low: [[f64; 3usize]; 3usize],
    pub enclosure_high: [[f64; 3usize]; 3usize],
    pub enclosure_radius: [f64; 3usize],
    /// Largest gap of the curves along its borders.
    pub gap: f64,
    pub rim: u32,
    pub unused: [u32; 3usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of ScenePatch"][::core::mem::size_of::<ScenePatch>() - 304usize];
    ["Alignment of ScenePatch"][::core::mem::align_of::<ScenePatch>() - 16usize];
    [
        "Offset of field: ScenePatch::points",
    ][::core::mem::offset_of!(ScenePatch, points) - 0usize];
    [
        "Offset of field: ScenePatch::degree",
    ][::core::mem::offset_of!(ScenePatch, degree) - 4usize];
    [
        "Offset of field: ScenePatch::sides",
    ][::core::mem::offset_of!(ScenePatch, sides) - 6usize];
    [
        "Offset of field: ScenePatch::rational",
    ][::core::mem::offset_of!(ScenePatch, rational) - 7usize];
    [
        "Offset of field: ScenePatch::face",
    ][::core::mem::offset_of!(ScenePatch, face) - 8usize];
    [
        "Offset of field: ScenePatch::tree",
    ][::core::mem::offset_of!(ScenePatch, tree) - 12usize];
    [
        "Offset of field: ScenePatch::origin",
    ][::core::mem::offset_of!(ScenePatch, origin) - 16usize];
    [
        "Offset of field: ScenePatch::cone_axis",
    ][::core::mem::offset_of!(ScenePatch, cone_axis) - 40usize];
    [
        "Offset of field: ScenePatch::cone_cos",
    ][::core::mem::offset_of!(ScenePatch, cone_cos) - 64usize];
    [
        "Offset of field: ScenePatch::radius",
    ][::core::mem::offset_of!(ScenePatch, radius) - 72usize];
    [
        "Offset of field: ScenePatch::domain",
    ][::core::mem::offset_of!(ScenePatch, domain) - 80usize];
    [
        "Offset of field: ScenePatch::enclosure_low",
    ][::core::mem::offset_of!(ScenePatch, enclosure_low) - 112usize];
    [
        "Offset of field: ScenePatch::enclosure_high",
    ][::core::mem::offset_of!(ScenePatch, enclosure_high) - 184usize];
    [
        "Offset of field: ScenePatch::enclosure_radius",
    ][::core::mem::offset_of!(ScenePatch, enclosure_radius) - 256usize];
    [
        "Offset of field: ScenePatch::gap",
    ][::core::mem::offset_of!(ScenePatch, gap) - 280usize];
    [
        "Offset of field: ScenePatch::rim",
    ][::core::mem::offset_of!(ScenePatch, rim) - 288usize];
    [
        "Offset of field: ScenePatch::unused",
    ][::core::mem::offset_of!(ScenePatch, unused) - 292usize];
};
/// An instance: it draws a range of the scene's patches.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct SceneInstance {
    /// Columns of the linear part.
    pub matrix: [[f64; 3usize]; 3usize],
    pub translation: [f64; 3usize],
    pub first_patch: u32,
    /// The number of its first patch among those of all instances.
    pub first_item: u32,
    /// Colours of single faces, ascending.
    pub first_color: u32,
    pub colors: u32,
    pub color: [f32; 3usize],
    pub has_color: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of SceneInstance"][::core::mem::size_of::<SceneInstance>() - 128usize];
    ["Alignment of SceneInstance"][::core::mem::align_of::<SceneInstance>() - 8usize];
    [
        "Offset of field: SceneInstance::matrix",
    ][::core::mem::offset_of!(SceneInstance, matrix) - 0usize];
    [
        "Offset of field: SceneInstance::translation",
    ][::core::mem::offset_of!(SceneInstance, translation) - 72usize];
    [
        "Offset of field: SceneInstance::first_patch",
    ][::core::mem::offset_of!(SceneInstance, first_patch) - 96usize];
    [
        "Offset of field: SceneInstance::first_item",
    ][::core::mem::offset_of!(SceneInstance, first_item) - 100usize];
    [
        "Offset of field: SceneInstance::first_color",
    ][::core::mem::offset_of!(SceneInstance, first_color) - 104usize];
    [
        "Offset of field: SceneInstance::colors",
    ][::core::mem::offset_of!(SceneInstance, colors) - 108usize];
    [
        "Offset of field: SceneInstance::color",
    ][::core::mem::offset_of!(SceneInstance, color) - 112usize];
    [
        "Offset of field: SceneInstance::has_color",
    ][::core::mem::offset_of!(SceneInstance, has_color) - 124usize];
};
/// What a face is coloured.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct FaceColor {
    pub face: u32,
    pub color: [f32; 3usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of FaceColor"][::core::mem::size_of::<FaceColor>() - 16usize];
    ["Alignment of FaceColor"][::core::mem::align_of::<FaceColor>() - 4usize];
    [
        "Offset of field: FaceColor::face",
    ][::core::mem::offset_of!(FaceColor, face) - 0usize];
    [
        "Offset of field: FaceColor::color",
    ][::core::mem::offset_of!(FaceColor, color) - 4usize];
};
/// One more than the most quads along a side of a leaf: 7 x 7 blocks round 2^12 up.
pub const BASIS_SIDES: u32 = 4103;
/// What becomes of a patch in an instance: `state` of an item.
pub const ITEM_CULLED: u32 = 0;
/// Drawn as a whole.
pub const ITEM_WHOLE: u32 = 1;
/// Drawn in parts, if at all.
pub const ITEM_SPLIT: u32 = 2;
/// A patch that is not culled, and its grid where it is drawn as a whole.
#[repr(C)]
#[repr(align(8))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Visible {
    pub item: u32,
    pub state: u32,
    pub quads: [u16; 2usize],
    pub diagonal: u32,
    pub deviation: [f32; 2usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Visible"][::core::mem::size_of::<Visible>() - 24usize];
    ["Alignment of Visible"][::core::mem::align_of::<Visible>() - 8usize];
    ["Offset of field: Visible::item"][::core::mem::offset_of!(Visible, item) - 0usize];
    [
        "Offset of field: Visible::state",
    ][::core::mem::offset_of!(Visible, state) - 4usize];
    [
        "Offset of field: Visible::quads",
    ][::core::mem::offset_of!(Visible, quads) - 8usize];
    [
        "Offset of field: Visible::diagonal",
    ][::core::mem::offset_of!(Visible, diagonal) - 12usize];
    [
        "Offset of field: Visible::deviation",
    ][::core::mem::offset_of!(Visible, deviation) - 16usize];
};
/// What stops a frame, with the item at which it happens.
pub const ERROR_TOO_MANY_LEAVES: u32 = 1;
pub const ERROR_TOO_CLOSE: u32 = 2;
pub const ERROR_GRID_TOO_LARGE: u32 = 3;
pub const ERROR_TOLERANCE: u32 = 4;
pub const NO_ERROR: u64 = 18446744073709551615;
/// What estimate counts.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Counters {
    /// The least `item << 8 | error`, or NO_ERROR.
    pub error: u64,
    /// Control points of parts.
    pub part_points: u64,
    /// Patches that are to be split, and how many of them have been taken.
    pub split: u32,
    pub taken: u32,
    /// Leaves that splitting makes; they may be more than there is room for.
    pub parts: u32,
    /// Patches of which something is drawn.
    pub visible: u32,
    /// A warp's list of halves was too short.
    pub short_of_halves: u32,
    pub unused: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Counters"][::core::mem::size_of::<Counters>() - 40usize];
    ["Alignment of Counters"][::core::mem::align_of::<Counters>() - 8usize];
    [
        "Offset of field: Counters::error",
    ][::core::mem::offset_of!(Counters, error) - 0usize];
    [
        "Offset of field: Counters::part_points",
    ][::core::mem::offset_of!(Counters, part_points) - 8usize];
    [
        "Offset of field: Counters::split",
    ][::core::mem::offset_of!(Counters, split) - 16usize];
    [
        "Offset of field: Counters::taken",
    ][::core::mem::offset_of!(Counters, taken) - 20usize];
    [
        "Offset of field: Counters::parts",
    ][::core::mem::offset_of!(Counters, parts) - 24usize];
    [
        "Offset of field: Counters::visible",
    ][::core::mem::offset_of!(Counters, visible) - 28usize];
    [
        "Offset of field: Counters::short_of_halves",
    ][::core::mem::offset_of!(Counters, short_of_halves) - 32usize];
    [
        "Offset of field: Counters::unused",
    ][::core::mem::offset_of!(Counters, unused) - 36usize];
};
/** A part of a patch by the halvings that lead to it, the first one in the lowest bit: which way they cut (0: across u) and
 which half they took (0: the lower one); and its grid.*/
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Half {
    pub axes: [u64; 2usize],
    pub sides: [u64; 2usize],
    pub depth: u32,
    pub diagonal: u32,
    pub quads: [u32; 2usize],
    pub deviation: [f32; 2usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of Half"][::core::mem::size_of::<Half>() - 56usize];
    ["Alignment of Half"][::core::mem::align_of::<Half>() - 8usize];
    ["Offset of field: Half::axes"][::core::mem::offset_of!(Half, axes) - 0usize];
    ["Offset of field: Half::sides"][::core::mem::offset_of!(Half, sides) - 16usize];
    ["Offset of field: Half::depth"][::core::mem::offset_of!(Half, depth) - 32usize];
    [
        "Offset of field: Half::diagonal",
    ][::core::mem::offset_of!(Half, diagonal) - 36usize];
    ["Offset of field: Half::quads"][::core::mem::offset_of!(Half, quads) - 40usize];
    [
        "Offset of field: Half::deviation",
    ][::core::mem::offset_of!(Half, deviation) - 48usize];
};
/// A leaf whose halves are tried: places in a warp's list of halves.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct HalvedLeaf {
    /// Its halves, and the next one to be looked at.
    pub first: u32,
    pub next: u32,
    pub end: u32,
    /// More halvings that may pass without a gain.
    pub tries: u32,
    /// Quads of its own grid, and of the parts found so far.
    pub quads: u32,
    pub part_quads: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of HalvedLeaf"][::core::mem::size_of::<HalvedLeaf>() - 24usize];
    ["Alignment of HalvedLeaf"][::core::mem::align_of::<HalvedLeaf>() - 4usize];
    [
        "Offset of field: HalvedLeaf::first",
    ][::core::mem::offset_of!(HalvedLeaf, first) - 0usize];
    [
        "Offset of field: HalvedLeaf::next",
    ][::core::mem::offset_of!(HalvedLeaf, next) - 4usize];
    [
        "Offset of field: HalvedLeaf::end",
    ][::core::mem::offset_of!(HalvedLeaf, end) - 8usize];
    [
        "Offset of field: HalvedLeaf::tries",
    ][::core::mem::offset_of!(HalvedLeaf, tries) - 12usize];
    [
        "Offset of field: HalvedLeaf::quads",
    ][::core::mem::offset_of!(HalvedLeaf, quads) - 16usize];
    [
        "Offset of field: HalvedLeaf::part_quads",
    ][::core::mem::offset_of!(HalvedLeaf, part_quads) - 20usize];
};
/// Where a leaf that splitting made belongs: its visible patch, and its number among the leaves of it.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct PartPlace {
    pub visible: u32,
    pub number: u32,
    /// First of its control points in the list of parts.
    pub net: u32,
    pub unused: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of PartPlace"][::core::mem::size_of::<PartPlace>() - 16usize];
    ["Alignment of PartPlace"][::core::mem::align_of::<PartPlace>() - 4usize];
    [
        "Offset of field: PartPlace::visible",
    ][::core::mem::offset_of!(PartPlace, visible) - 0usize];
    [
        "Offset of field: PartPlace::number",
    ][::core::mem::offset_of!(PartPlace, number) - 4usize];
    [
        "Offset of field: PartPlace::net",
    ][::core::mem::offset_of!(PartPlace, net) - 8usize];
    [
        "Offset of field: PartPlace::unused",
    ][::core::mem::offset_of!(PartPlace, unused) - 12usize];
};
/// What becomes of a block of a leaf's grid: its leaf has no trims; it is looked at; all of it lies outside the trims.
pub const BLOCK_FREE: u32 = 0;
pub const BLOCK_CUT: u32 = 1;
pub const BLOCK_OUTSIDE: u32 = 2;
/// What the meshlet list counts.
#[repr(C)]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct MeshletCounts {
    pub quads: u64,
    /// Meshlets of trimmed leaves that no curve crosses.
    pub inside: u32,
    /// Those that one may cross.
    pub boundary: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of MeshletCounts"][::core::mem::size_of::<MeshletCounts>() - 16usize];
    ["Alignment of MeshletCounts"][::core::mem::align_of::<MeshletCounts>() - 8usize];
    [
        "Offset of field: MeshletCounts::quads",
    ][::core::mem::offset_of!(MeshletCounts, quads) - 0usize];
    [
        "Offset of field: MeshletCounts::inside",
    ][::core::mem::offset_of!(MeshletCounts, inside) - 8usize];
    [
        "Offset of field: MeshletCounts::boundary",
    ][::core::mem::offset_of!(MeshletCounts, boundary) - 12usize];
};
