//! What a frame is asked to do; the names are those of the command line.

pub use crate::cuda::selection::Precision;
use serde::{Deserialize, Serialize};

/// The tessellation bound (DESIGN section 4). Each certifies one interpolation of the parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Bound {
    /// Per-axis bound from object-space enclosures of the second derivatives; proved, affine.
    #[default]
    Screen,
    /// ETER: object-space epsilon with Zheng & Sederberg's homogeneous bound; proved, projective.
    Eter,
    /// Guthe 2005 section 5.2 after Filip; proved, affine.
    Filip,
    /// Clip-space second differences; proved, projective.
    Projective,
    /// Yeo 2012 (iPASS); polynomial patches only and no guarantee.
    Slefe,
}

/// Which parameter a pixel inside a triangle gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Vertices divided by the rational weight: affine on the triangle in camera space.
    Affine,
    /// The rational weight stays in W.
    Projective,
}

/// How a leaf is cut into quads, and these into meshlets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Grid {
    /// As `variable`, and large leaves are halved where their halves ask for clearly fewer quads.
    #[default]
    Adaptive,
    /// As many quads as the bound asks for, in meshlets of up to 7x7.
    Variable,
    /// ETER section 4.2: scaled up to whole 7x7-quad meshlets.
    Eter,
    /// The same, with so many quads that no triangle is larger than 16x16 pixels (section 6.2, equation 2).
    Eter16,
}

/// How cracks between grids are closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Fill {
    #[default]
    Stroke,
    /// ETER section 6.1: conservative fragments and the 3x3 vote.
    Eter,
    Conservative,
    Off,
}

/// Back-patch culling for surfaces that bound a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Cull {
    Off,
    #[default]
    Auto,
    /// Also for surfaces that are not known to bound a solid.
    On,
}

/// The shape of a frame on a device; the CPU has one of its own. All draw the same words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum FrameShape {
    /// Vertices are evaluated where they are drawn: no memory holds them.
    #[default]
    Fused,
    /// ETER's own: meshlets of vertices in memory, then the rasteriser.
    Staged,
}

/// What turns triangles into fragments. All draw the same words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Raster {
    /// Software, until a GPU has been measured to be faster
    #[default]
    Auto,
    /// The backend's own
    Software,
    /// Vulkan mesh shaders for patches of large triangles, software for the others
    Hybrid,
    /// Vulkan mesh shaders for all
    Hardware,
}

/// By what a leaf's quads are large (`Raster::Hybrid`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Route {
    /// Differences of the projected control points: the sides of quads, nearly.
    #[default]
    Net,
    /// ETER section 6.2: its bound on the edges of triangles, from the first derivative (equation 2).
    Eter,
}

/// How trim loops cut their faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Trim {
    /// On the exact surface under each pixel's centre.
    #[default]
    On,
    /// Guthe 2005: a parity texture for each leaf, sized for the error.
    Texture,
    /// Patches are drawn whole, but for those that lie outside altogether.
    Off,
}

/// What the picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Show {
    #[default]
    Shaded,
    Patches,
    Grid,
    Meshlets,
    Normals,
    Depth,
    Error,
    TriangleSize,
}

/// Everything that changes a frame besides the camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Options {
    pub bound: Bound,
    pub grid: Grid,
    pub fill: Fill,
    pub cull: Cull,
    pub trim: Trim,
    pub show: Show,
    pub frame: FrameShape,
    pub raster: Raster,
    /// Pixels along the longer side of a quad from which on `Raster::Hybrid` gives its leaf to hardware; `None`: what `bench
    /// raster` found for the device. Changes no pixel.
    pub large: Option<f64>,
    pub route: Route,
    /// Of evaluation on a device; the CPU has f32 alone.
    pub precision: Precision,
    /// Newton steps towards the pixel centre; 0 is the papers' way.
    pub refine: u32,
    /// Pixels.
    pub tolerance: f64,
    /// Pixel sizes.
    pub depth_tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            bound: Bound::Screen,
            grid: Grid::Adaptive,
            fill: Fill::Stroke,
            cull: Cull::Auto,
            trim: Trim::On,
            show: Show::Shaded,
            frame: FrameShape::Fused,
            raster: Raster::Auto,
            large: None,
            route: Route::default(),
            precision: Precision::F32,
            refine: 2,
            tolerance: 0.5,
            depth_tolerance: 1.0,
        }
    }
}

impl Options {
    /// The shape that a frame of a device really has: mesh shaders draw vertices in memory.
    pub fn shape(&self) -> FrameShape {
        if self.raster.is_hardware() { FrameShape::Staged } else { self.frame }
    }
}

impl Raster {
    /// Vulkan is asked for by name.
    pub fn is_hardware(self) -> bool {
        matches!(self, Raster::Hybrid | Raster::Hardware)
    }
}

impl Bound {
    pub const ALL: [Bound; 5] = [Bound::Screen, Bound::Eter, Bound::Filip, Bound::Projective, Bound::Slefe];

    /// The interpolation this bound certifies.
    pub fn interpolation(self) -> Interpolation {
        match self {
            Bound::Screen | Bound::Filip | Bound::Slefe => Interpolation::Affine,
            Bound::Eter | Bound::Projective => Interpolation::Projective,
        }
    }
}
