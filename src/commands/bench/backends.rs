//! Frames of a backend against the CPU's, pixel by pixel: what differs, and by how much.

use super::ResultArgs;
use super::sheet::{STAMP, Sheet, stamp};
use crate::commands::UsageError;
use crate::commands::args::FrameArgs;
use crate::commands::used::Used;
use crate::report::{Cell, Machine, Table, name};
use crate::scene::{Camera, Scene};
use crate::stages::{Bound, Engine, Fill, Frame, FrameShape, Grid, Options, Precision, RenderError, Renderer};
use anyhow::Result;
use std::process::ExitCode;

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// Pixels of two frames that are not the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Difference {
    pub(super) pixels: u64,
    pub(super) drawn: u64,
    /// Visibility words: what most of the frame is made of.
    pub(super) words: u64,
    /// Pixels that show another patch, or only one of which is background.
    pub(super) patches: u64,
    /// Largest difference of stored depth where both show the same patch.
    depth: f64,
    /// Of those: other stored parameters, by how much at most.
    parameters: u64,
    parameter: f64,
    pub(super) colors: u64,
    /// Largest difference of linear RGB.
    color: f64,
}

/// Frames that are compared.
const FRAMES: usize = 3;

/// One model in one configuration.
struct Finding {
    model: String,
    options: Options,
    outcome: Result<Difference, Refused>,
}

/// A frame that was not drawn.
pub(super) struct Refused {
    pub(super) error: RenderError,
    /// By the CPU for the same reason.
    pub(super) alike: bool,
}

impl Refused {
    pub(super) fn note(&self) -> String {
        let who = if self.alike { "refused" } else { "REFUSED BY ONE ALONE" };
        format!("{who}: {}", self.error)
    }
}

/// The CPU's frame and a device's; or why there are not both.
pub(super) fn both(
    cpu: Result<Frame, RenderError>,
    device: Result<Frame, RenderError>,
) -> Result<(Frame, Frame), Refused> {
    match (cpu, device) {
        (Ok(cpu), Ok(device)) => Ok((cpu, device)),
        (Err(cpu), Err(error)) => Err(Refused { alike: cpu == error, error }),
        (Err(error), Ok(_)) | (Ok(_), Err(error)) => Err(Refused { error, alike: false }),
    }
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let engine = args.frame.backend.engine()?;
    if matches!(engine, Engine::Cpu) {
        return Err(UsageError(
            "frames of the CPU are what others are compared with: give --backend cuda or emulated".into(),
        )
        .into());
    }
    let used = Used::new(&args.frame.options(), &engine);
    drop(engine);
    let mut found = Vec::new();
    args.frame.model.install(|| {
        for model in args.frame.model.each() {
            let (loaded, scene) = model.load_scene()?;
            let camera = args.frame.camera(&scene)?;
            let mut renderer = Renderer::with(&scene, args.frame.backend.engine()?);
            for options in configurations(&args.frame.options()) {
                let outcome = worst(&scene, &mut renderer, &camera, &options);
                found.push(Finding { model: loaded.name.clone(), options, outcome });
            }
        }
        Ok(())
    })?;
    let machine = Machine { device: used.device, ..Machine::here(used.threads) };
    let same = |f: &Finding| f.outcome.as_ref().map_or_else(|refused| refused.alike, |d| d.words + d.colors == 0);
    let differ = !found.iter().all(same);
    let verdict = if differ { "THERE ARE DIFFERENCES." } else { "All words and colours are the same." };
    let [width, height] = args.frame.size;
    let sheet = Sheet {
        suite: "backends",
        title: "Frames against the CPU's",
        about: format!(
            "{width}x{height}, the first {FRAMES} frames of a renderer, whichever differs most. Words are visibility words (depth, meshlet, index); depth, parameters are compared where both \
             frames show the same patch. {verdict}"
        ),
        tables: vec![("Differences".into(), table(&found, &[]))],
        rows: table(&found, &stamp(used.backend, &machine)),
        backend: used.backend,
        machine,
    };
    sheet.publish(&args.results)?;
    // Another precision has words of its own.
    let fails = differ && args.frame.options().precision == Precision::F32;
    Ok(if fails { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// A device's first frame asks for the lengths of its lists, the next one has room for them, and the third one is run as a whole:
/// whichever differs most.
fn worst(scene: &Scene, renderer: &mut Renderer, camera: &Camera, options: &Options) -> Result<Difference, Refused> {
    let mut worst = Difference::default();
    for _ in 0..FRAMES {
        let cpu = Renderer::new(scene).render(camera, &Options { precision: Precision::F32, ..*options });
        let (expected, frame) = both(cpu, renderer.render(camera, options))?;
        let found = Difference::of(&expected, &frame);
        if worst.pixels == 0 || found.words + found.colors > worst.words + worst.colors {
            worst = found;
        }
    }
    Ok(worst)
}

/// What was asked for, the same staged, and what ETER draws.
fn configurations(ours: &Options) -> [Options; 3] {
    let staged = Options { frame: FrameShape::Staged, ..*ours };
    [*ours, staged, Options { bound: Bound::Eter, grid: Grid::Eter, fill: Fill::Eter, ..staged }]
}

impl Difference {
    pub(super) fn of(expected: &Frame, found: &Frame) -> Self {
        let [width, height] = expected.size();
        let mut all = Self { pixels: u64::from(width) * u64::from(height), ..Self::default() };
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            all.words += u64::from(expected.word(x, y) != found.word(x, y));
            let (a, b) = (expected.pixel(x, y), found.pixel(x, y));
            all.drawn += u64::from(a.is_some());
            match (a, b) {
                (Some(a), Some(b)) if (a.instance, a.patch) == (b.instance, b.patch) => {
                    all.depth = all.depth.max(f64::from((a.depth - b.depth).abs()));
                    let off = (a.stored[0] - b.stored[0]).abs().max((a.stored[1] - b.stored[1]).abs());
                    all.parameters += u64::from(off != 0.0);
                    all.parameter = all.parameter.max(off);
                }
                (a, b) => all.patches += u64::from(a.is_some() || b.is_some()),
            }
            let colors = expected.color(x, y).into_iter().zip(found.color(x, y));
            let off = colors.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
            all.colors += u64::from(off != 0.0);
            all.color = all.color.max(off);
        }
        all
    }
}

fn table(found: &[Finding], stamped: &[Cell]) -> Table {
    let headings = [
        "model",
        "bound",
        "grid",
        "fill",
        "frame",
        "pixels",
        "drawn",
        "words",
        "patches",
        "depth",
        "parameters",
        "largest parameter",
        "colours",
        "largest colour",
        "note",
    ];
    let stamp = if stamped.is_empty() { &[][..] } else { &STAMP };
    let mut table = Table::new(&[&headings[..], stamp].concat());
    for Finding { model, options, outcome } in found {
        let difference = outcome.as_ref().ok();
        let count = |get: fn(&Difference) -> u64| Cell::from(difference.map(get));
        let number = |get: fn(&Difference) -> f64| Cell::from(difference.map(get));
        let cells = [
            model.as_str().into(),
            name(options.bound).into(),
            name(options.grid).into(),
            name(options.fill).into(),
            name(options.frame).into(),
            count(|d| d.pixels),
            count(|d| d.drawn),
            count(|d| d.words),
            count(|d| d.patches),
            number(|d| d.depth),
            count(|d| d.parameters),
            number(|d| d.parameter),
            count(|d| d.colors),
            number(|d| d.color),
            outcome.as_ref().err().map_or(String::new(), Refused::note).into(),
        ];
        table.push(cells.into_iter().chain(stamped.iter().cloned()).collect());
    }
    table
}
