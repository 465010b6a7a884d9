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
pub mod GridClass {
    #[allow(unused_imports)]
    use super::*;
    /// How a grid is drawn by the fused frame: what one lane is given (research "kernel-study", question 3).
    pub type Type = u32;
    /// 1 x 1 quad: a thread a patch, from the four corners alone.
    pub const GRID_CORNERS: Type = 0;
    /// 1 x k quads: a thread a patch.
    pub const GRID_ROW: Type = 1;
    /// Up to 3 quads across: 4 lanes a patch.
    pub const GRID_NARROW: Type = 2;
    /// Up to 7 quads across: 8 lanes a patch. Larger grids are cut into meshlets of this class.
    pub const GRID_WIDE: Type = 3;
}
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
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of View"][::core::mem::size_of::<View>() - 144usize];
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
/// A block of up to 7 x 7 quads of one patch's grid. 16 bytes: one load (20 cost five).
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Default, Copy, Clone, PartialEq)]
pub struct Meshlet {
    pub patch: u32,
    /// First of its (quads[0] + 1)(quads[1] + 1) vertices, v innermost.
    pub vertices: u32,
    /// Its first quad in the patch's grid.
    pub first: [u16; 2usize],
    pub quads: [u8; 2usize],
    /// Which of its sides (u=0, u=1, v=0, v=1) are the patch's, or border on a meshlet that is trimmed away: bits 0 to 3.
    pub outer: u8,
    /// 1: a trim curve crosses it.
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
