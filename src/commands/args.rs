//! Arguments that commands share: everything that decides a frame.

use super::UsageError;
use super::backend::{self, Backend};
use super::source::ModelArgs;
use crate::scene::{Camera, MAX_SIDE, Scene, View, ViewSpec};
use crate::stages::{Bound, Cull, Fill, FrameShape, Grid, Options, Precision, Raster, Route, Show, Trim};
use anyhow::{Result, bail};
use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec3;

/// More pixels than this need a renderer that works in tiles.
const MAX_PIXELS: u64 = 1 << 27;

/// What a frame shows and how it is made: for `render`, `verify`, `compare` and `bench`.
#[derive(Clone, Debug, clap::Args)]
pub struct FrameArgs {
    #[command(flatten)]
    pub model: ModelArgs,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: [u32; 2],
    /// Where to look from
    #[arg(long, value_enum, default_value_t)]
    pub view: View,
    #[arg(long, value_enum, default_value_t, help = "How space becomes an image")]
    pub projection: ProjectionKind,
    /// Eye position instead of a named view
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,
    /// Point to look at [default: the model's centre]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub target: Option<DVec3>,
    /// Direction that points up in the image
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_direction, allow_hyphen_values = true)]
    pub up: Option<DVec3>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = ViewSpec::default().fov, value_parser = parse_fov,
          allow_hyphen_values = true)]
    pub fov: f64,
    /// Magnification about the image centre
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = parse_zoom, allow_hyphen_values = true)]
    pub zoom: f64,
    /// Tessellation bound
    #[arg(long, value_enum, default_value_t)]
    pub bound: Bound,
    /// How quads are grouped into meshlets
    #[arg(long, value_enum, default_value_t)]
    pub grid: Grid,
    /// How cracks between grids are closed
    #[arg(long, value_enum, default_value_t)]
    pub fill: Fill,
    /// Newton steps a pixel towards the exact surface point
    #[arg(long, value_name = "N", default_value_t = Options::default().refine,
          value_parser = clap::value_parser!(u32).range(0..=16), allow_hyphen_values = true)]
    pub refine: u32,
    /// Back-patch culling
    #[arg(long, value_enum, default_value_t)]
    pub cull: Cull,
    /// How trim loops cut their faces
    #[arg(long, value_enum, default_value_t)]
    pub trim: Trim,
    /// Largest error in the image, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = Options::default().tolerance, value_parser = parse_tolerance,
          allow_hyphen_values = true)]
    pub tolerance: f64,
    /// Largest error in depth, in pixel sizes
    #[arg(long, value_name = "PIXELS", default_value_t = Options::default().depth_tolerance,
          value_parser = parse_depth_tolerance, allow_hyphen_values = true)]
    pub depth_tolerance: f64,
    /// What draws the frame
    #[arg(long, value_enum, default_value_t)]
    pub backend: Backend,
    /// What turns triangles into fragments
    #[arg(long, value_parser = raster_parser(), default_value = "auto")]
    pub raster: Raster,
    /// Quads of so many pixels and more are hardware's in --raster hybrid [default: what `bench raster` found]
    #[arg(long, value_name = "PIXELS", value_parser = parse_large, allow_hyphen_values = true)]
    pub large: Option<f64>,
    /// By what quads are large, for --raster hybrid
    #[arg(long, value_enum, default_value_t)]
    pub route: Route,
    /// How a GPU's frame is made [default: fused]
    #[arg(long, value_enum)]
    pub frame: Option<FrameShape>,
    /// What a GPU evaluates patches in: tensor cores are used by all but f32 [default: f32]
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t)]
    pub show: Show,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ProjectionKind {
    #[default]
    Perspective,
    Orthographic,
}

impl FrameArgs {
    /// What the frame is asked to do, besides the camera.
    pub fn options(&self) -> Options {
        Options {
            bound: self.bound,
            grid: self.grid,
            fill: self.fill,
            cull: self.cull,
            trim: self.trim,
            show: self.show,
            frame: self.frame.unwrap_or_default(),
            raster: self.raster,
            large: self.large,
            route: self.route,
            precision: self.precision.unwrap_or_default(),
            refine: self.refine,
            tolerance: self.tolerance,
            depth_tolerance: self.depth_tolerance,
        }
    }

    /// Refuses what is for the kernels of a GPU alone where the CPU draws.
    pub fn check_kernels(&self) -> Result<()> {
        if matches!(self.backend, Backend::Cuda | Backend::Emulated) {
            return Ok(());
        }
        let exact = self.precision.is_none_or(|p| matches!(p, Precision::Auto | Precision::F32));
        let asked = if self.frame.is_some() {
            "--frame is"
        } else if !exact {
            "--precision other than auto and f32 is"
        } else {
            return Ok(());
        };
        Err(UsageError(format!("{asked} for the kernels of a GPU: add --backend cuda or --backend emulated")).into())
    }

    /// Refuses what hardware is asked to rasterise and can't.
    pub fn check_raster(&self) -> Result<()> {
        if !self.raster.is_hardware() {
            return Ok(());
        }
        let name = self.raster.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default();
        if self.frame == Some(FrameShape::Fused) {
            let why = "draws vertices that are in memory: add --frame staged";
            return Err(UsageError(format!("--raster {name} {why}")).into());
        }
        let missing = backend::vulkan_missing();
        if missing.is_empty() { Ok(()) } else { bail!("--raster {name} can't be used: {}", missing.join("; ")) }
    }

    /// The camera that was asked for, before it knows the model.
    pub fn view_spec(&self) -> ViewSpec {
        ViewSpec {
            size: self.size,
            view: self.view,
            orthographic: self.projection == ProjectionKind::Orthographic,
            fov: self.fov,
            zoom: self.zoom,
            eye: self.eye,
            target: self.target,
            up: self.up,
        }
    }

    /// The camera for a prepared model.
    pub fn camera(&self, scene: &Scene) -> Result<Camera> {
        if self.eye.is_some() && self.eye == self.target {
            return Err(UsageError("--eye and --target are the same point: move one of them".into()).into());
        }
        Ok(self.view_spec().camera(&scene.bounds)?)
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let size: [u32; 2] = sides.ok_or("expected WxH in pixels, as in 1280x720")?;
    if size.iter().any(|s| !(1..=MAX_SIDE).contains(s)) {
        return Err(format!("sides must be 1 to {MAX_SIDE} pixels"));
    }
    if u64::from(size[0]) * u64::from(size[1]) > MAX_PIXELS {
        return Err(format!("at most {MAX_PIXELS} pixels"));
    }
    Ok(size)
}

fn parse_number(text: &str) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| format!("{text:?} is not a number"))?;
    if number.is_finite() { Ok(number) } else { Err("must be finite".into()) }
}

fn parse_point(text: &str) -> Result<DVec3, String> {
    let numbers = text.split(',').map(parse_number).collect::<Result<Vec<_>, _>>()?;
    let point: [f64; 3] = numbers.try_into().map_err(|_| "expected three numbers X,Y,Z")?;
    // Squares stay in range.
    if point.iter().any(|x| x.abs() > 1e100) {
        return Err("coordinates must be at most 1e100".into());
    }
    Ok(point.into())
}

fn parse_direction(text: &str) -> Result<DVec3, String> {
    let direction = parse_point(text)?;
    if direction.try_normalize().is_some() { Ok(direction) } else { Err("must be longer than zero".into()) }
}

/// A number in (low, high].
fn parse_in(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let number = parse_number(text)?;
    if number > low && number <= high { Ok(number) } else { Err(format!("must be above {low} and at most {high}")) }
}

fn parse_fov(text: &str) -> Result<f64, String> {
    let number = parse_number(text)?;
    if number > 0.0 && number < 180.0 { Ok(number) } else { Err("must be between 0 and 180 degrees".into()) }
}

pub(super) fn parse_zoom(text: &str) -> Result<f64, String> {
    parse_in(text, 0.0, 1e12)
}

pub(super) fn parse_tolerance(text: &str) -> Result<f64, String> {
    parse_in(text, 0.0, 10.0)
}

/// The rasterisers, and a hint for who looks for ETER's baseline among them.
fn raster_parser() -> impl TypedValueParser<Value = Raster> {
    let rasterisers = Raster::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let baseline = PossibleValue::new("tessellation").hide(true);
    PossibleValuesParser::new(rasterisers.chain([baseline])).try_map(|name| match name.as_str() {
        "tessellation" => {
            Err("it draws no picture, as in ETER's table 3: see `halfpixel bench tessellation`".to_owned())
        }
        name => Raster::from_str(name, false),
    })
}

fn parse_large(text: &str) -> Result<f64, String> {
    let number = parse_number(text)?;
    if number >= 0.0 { Ok(number) } else { Err("must not be negative".into()) }
}

pub(super) fn parse_width(text: &str) -> Result<f64, String> {
    parse_in(text, 0.0, 1e5)
}

fn parse_depth_tolerance(text: &str) -> Result<f64, String> {
    parse_in(text, 0.0, 1e6)
}
