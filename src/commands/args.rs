//! Arguments that commands share: the model, and everything that decides a frame.

use super::{UsageError, output};
use crate::import::{self, ImportError};
use crate::model::Model;
use crate::scene::{Camera, MAX_SIDE, Scene, View, ViewSpec, prepare};
use crate::stages::{Bound, Cull, Fill, Grid, Options, Show, Trim};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use glam::{DAffine3, DMat3, DVec3};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// More pixels than this need a renderer that works in tiles.
const MAX_PIXELS: u64 = 1 << 27;

/// What is read, and how.
#[derive(Clone, Debug, clap::Args)]
pub struct ModelArgs {
    /// File to read (its content decides the format), or builtin:NAME
    #[arg(value_name = "MODEL")]
    pub model: String,
    /// The model's axis that points up; y turns the model so that it becomes z
    #[arg(long, value_enum, default_value_t, value_name = "AXIS")]
    pub up_axis: UpAxis,
    /// Fail where something in the file could not be taken over
    #[arg(long)]
    pub strict: bool,
    /// Threads to use [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
          allow_hyphen_values = true)]
    pub threads: Option<u16>,
}

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
    /// What the picture shows
    #[arg(long, value_enum, default_value_t)]
    pub show: Show,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    Y,
    #[default]
    Z,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ProjectionKind {
    #[default]
    Perspective,
    Orthographic,
}

impl ModelArgs {
    /// Reads the model and turns it upright. What could not be taken over is counted on standard error, or with
    /// `--strict` an error.
    pub fn load(&self) -> Result<Model> {
        let model = self.load_silently()?;
        if let Some(line) = warnings_line(&model) {
            output::warning_line(&format!("{}: {line}; `halfpixel info` lists them", self.model));
        }
        Ok(model)
    }

    /// As `load`, for a caller that shows the warnings itself.
    pub fn load_silently(&self) -> Result<Model> {
        let mut model = load_model(&self.model)?;
        if let Some(line) = warnings_line(&model).filter(|_| self.strict) {
            bail!("{}: {line}: leave out --strict to go on without that", self.model);
        }
        if self.up_axis == UpAxis::Y {
            // A quarter turn about x takes +y to +z.
            let upright = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y));
            for instance in &mut model.instances {
                instance.transform = upright * instance.transform;
            }
        }
        Ok(model)
    }

    /// Reads and prepares the model, with a progress bar on a terminal.
    pub fn load_scene(&self) -> Result<(Model, Scene)> {
        let model = self.load()?;
        let scene = prepare_model(&model).with_context(|| self.model.clone())?;
        Ok((model, scene))
    }

    /// Runs `work` on `--threads` threads.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> Result<R> + Send) -> Result<R> {
        let threads = self.threads.map_or(0, usize::from);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.context("could not start the threads asked for: give a smaller --threads")?.install(work)
    }
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
            refine: self.refine,
            tolerance: self.tolerance,
            depth_tolerance: self.depth_tolerance,
        }
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

/// Reads a model from a file or by the name of a built-in one.
pub fn load_model(source: &str) -> Result<Model> {
    import::load(source).map_err(|error| match error {
        ImportError::Builtin(unknown) => UsageError(unknown.to_string()).into(),
        error => error.into(),
    })
}

/// Prepares a model; on a terminal, standard error shows how far it is.
pub fn prepare_model(model: &Model) -> Result<Scene> {
    let bar = progress_bar("preparing");
    let scene = prepare(model, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    Ok(scene?)
}

/// A progress bar on a terminal's standard error, nothing in a pipe.
pub fn progress_bar(what: &'static str) -> ProgressBar {
    // indicatif hides the bar by itself where standard error is not a terminal.
    let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

/// How many warnings a model has, and the first of them.
fn warnings_line(model: &Model) -> Option<String> {
    let first = &model.warnings.first()?.message;
    match model.warnings.len() {
        1 => Some(format!("1 warning: {first}")),
        count => Some(format!("{count} warnings, the first: {first}")),
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

fn parse_depth_tolerance(text: &str) -> Result<f64, String> {
    parse_in(text, 0.0, 1e6)
}
