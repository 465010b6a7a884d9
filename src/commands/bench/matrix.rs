//! Models x bounds x precisions x shapes of a frame x views: in f32 a backend's frames are the CPU's, in any other precision
//! they keep the contract, and every vertex lies within the derived bound.

use super::ResultArgs;
use super::backends::{Difference, Refused, both};
use super::pairs::pairwise;
use super::sheet::{STAMP, Sheet, stamp};
use crate::commands::UsageError;
use crate::commands::args::FrameArgs;
use crate::commands::used::Used;
use crate::report::{Cell, Machine, Table, name};
use crate::scene::{Camera, Scene, ViewSpec};
use crate::stages::{Bound, Engine, FrameShape, Options, Precision, Renderer};
use crate::verify::{Report, Sampling, verify};
use anyhow::Result;
use clap::ValueEnum;
use std::process::ExitCode;

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    /// As few frames as hold every pair of two choices
    #[arg(long)]
    pub pairwise: bool,
    /// Pixels the oracle checks a frame, drawn at random; as many again near borders
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub samples: usize,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// One frame.
#[derive(Clone, Copy, Debug)]
struct Case {
    model: usize,
    orthographic: bool,
    options: Options,
}

/// What came of it.
struct Finding {
    model: String,
    case: Case,
    outcome: Result<Found, Refused>,
}

struct Found {
    difference: Difference,
    /// Largest part of what bounds allow that a vertex differs from the one in f32.
    off: Option<f64>,
    /// Failures of the contract, and those of the CPU's frame where there are any.
    failures: u64,
    cpu_failures: u64,
    grid_error: Option<f64>,
    refined_error: Option<f64>,
}

impl Found {
    /// The CPU's frame in f32. Otherwise the contract is kept, but where a bound without a proof breaks it on the CPU too, and
    /// vertices lie within their bound.
    fn holds(&self, options: &Options) -> bool {
        let excused = options.bound == Bound::Slefe && self.cpu_failures > 0;
        match options.precision {
            Precision::F32 => self.difference.words == 0 && self.difference.colors == 0,
            _ => self.off.is_some_and(|off| off <= 1.0) && (self.failures == 0 || excused),
        }
    }
}

impl Finding {
    /// A frame that the CPU refuses for the same reason holds too: there is nothing to draw.
    fn holds(&self) -> bool {
        match &self.outcome {
            Ok(found) => found.holds(&self.case.options),
            Err(refused) => refused.alike,
        }
    }
}

/// Magnification of orthographic views: patches are larger, and cut by the image's borders.
const CLOSER: f64 = 5.0;

pub fn run(args: &Args) -> Result<ExitCode> {
    let engine = args.frame.backend.engine()?;
    if matches!(engine, Engine::Cpu) {
        let what = "the matrix compares a backend's frames with the CPU's: give --backend cuda or emulated";
        return Err(UsageError(what.into()).into());
    }
    let used = Used::new(&args.frame.options(), &engine);
    drop(engine);
    let models: Vec<_> = args.frame.model.each().collect();
    let mut found = Vec::new();
    args.frame.model.install(|| {
        let mut cases = cases(args, models.len());
        cases.sort_by_key(|case| case.model);
        for part in cases.chunk_by(|a, b| a.model == b.model) {
            let (loaded, scene) = models[part[0].model].load_scene()?;
            let mut renderer = Renderer::with(&scene, args.frame.backend.engine()?);
            for &case in part {
                let view = args.frame.view_spec();
                let zoom = if case.orthographic { view.zoom * CLOSER } else { view.zoom };
                let camera = ViewSpec { orthographic: case.orthographic, zoom, ..view }.camera(&scene.bounds)?;
                let outcome = measure(&scene, &mut renderer, &camera, &case.options, args.samples);
                found.push(Finding { model: loaded.name.clone(), case, outcome });
            }
        }
        Ok(())
    })?;
    let broken = found.iter().filter(|f| !f.holds()).count();
    sheet(args, &found, broken, used).publish(&args.results)?;
    Ok(if broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn cases(args: &Args, models: usize) -> Vec<Case> {
    let (bounds, precisions) = (Bound::ALL, Precision::value_variants());
    let shapes = [FrameShape::Fused, FrameShape::Staged];
    let levels = [models, bounds.len(), precisions.len(), shapes.len(), 2];
    let all = || {
        let count = levels.iter().product::<usize>();
        let choice = move |number: usize| {
            let mut rest = number;
            levels.map(|levels| {
                let level = rest % levels;
                rest /= levels;
                level
            })
        };
        (0..count).map(choice).collect()
    };
    let choices: Vec<[usize; 5]> = if args.pairwise { pairwise(levels) } else { all() };
    let case = |[model, bound, precision, shape, view]: [usize; 5]| {
        let (bound, precision, frame) = (bounds[bound], precisions[precision], shapes[shape]);
        Case { model, orthographic: view == 1, options: Options { bound, precision, frame, ..args.frame.options() } }
    };
    choices.into_iter().map(case).collect()
}

fn measure(
    scene: &Scene,
    renderer: &mut Renderer,
    camera: &Camera,
    options: &Options,
    samples: usize,
) -> Result<Found, Refused> {
    let expected = Renderer::new(scene).render(camera, &Options { precision: Precision::F32, ..*options });
    let (expected, frame) = both(expected, renderer.render(camera, options))?;
    let off = match options.precision {
        Precision::F32 => None,
        _ => renderer.vertices_off(camera, options).map_err(|error| Refused { error, alike: false })?,
    };
    let sampling = Sampling { samples: Some(samples), seed: 0 };
    let judge =
        |frame: &crate::stages::Frame| verify(scene, camera, options, &|x, y| frame.pixel(x, y), &sampling, &|_, _| {});
    let report = judge(&frame);
    let failures = failures(&report);
    Ok(Found {
        difference: Difference::of(&expected, &frame),
        off,
        failures,
        cpu_failures: if failures > 0 { self::failures(&judge(&expected)) } else { 0 },
        grid_error: report.grid_error_px.map(|e| e.max),
        refined_error: report.refined_error_px.map(|e| e.max),
    })
}

fn failures(report: &Report) -> u64 {
    report.violations + report.cracks + report.covering_failures + report.depth_failures
}

fn sheet(args: &Args, found: &[Finding], broken: usize, used: Used) -> Sheet {
    let machine = Machine { device: used.device, ..Machine::here(used.threads) };
    let [width, height] = args.frame.size;
    let refused = found.iter().filter(|f| f.outcome.is_err()).count();
    let alike = if found.iter().all(|f| f.outcome.as_ref().err().is_none_or(|refused| refused.alike)) {
        ", by the CPU alike"
    } else {
        ""
    };
    let verdict = match broken {
        0 => "All of them hold.".into(),
        n => format!("{n} OF THEM DO NOT HOLD."),
    };
    Sheet {
        suite: "matrix",
        title: "Models, bounds, precisions, shapes of a frame, views",
        about: format!(
            "{} frames of {width}x{height}{}, perspective and orthographic ({CLOSER} times closer); {refused} refused{alike}. f32 holds where words and colours are the CPU's; any other precision where the contract is kept on {} random \
             pixels a frame, as many near borders and all filled ones, or the CPU's frame breaks it too (slefe), and where no \
             vertex differs from f32's by more than both a-priori bounds and snapping together. {verdict}",
            found.len(),
            if args.pairwise { ", all pairs of two choices" } else { "" },
            args.samples
        ),
        tables: vec![
            ("By precision and frame".into(), summary(found)),
            ("What does not hold".into(), table(found, true, &[])),
        ],
        rows: table(found, false, &stamp(used.backend, &machine)),
        backend: used.backend,
        machine,
    }
}

fn summary(found: &[Finding]) -> Table {
    let mut table = Table::new(&[
        "precision",
        "frame",
        "frames",
        "refused",
        "hold",
        "pixels",
        "words as the CPU's",
        "vertices' part of the bound",
        "grid error max px",
        "refined max px",
        "failures",
    ]);
    for &precision in Precision::value_variants() {
        for shape in [FrameShape::Fused, FrameShape::Staged] {
            let own = |f: &&Finding| f.case.options.precision == precision && f.case.options.frame == shape;
            let all: Vec<&Finding> = found.iter().filter(own).collect();
            let drawn: Vec<&Found> = all.iter().filter_map(|f| f.outcome.as_ref().ok()).collect();
            // A bound without a proof says nothing of a precision.
            let proved = all.iter().filter(|f| f.case.options.bound != Bound::Slefe);
            let proved: Vec<&Found> = proved.filter_map(|f| f.outcome.as_ref().ok()).collect();
            let most =
                |get: fn(&Found) -> Option<f64>, of: &[&Found]| of.iter().filter_map(|f| get(f)).reduce(f64::max);
            let pixels: u64 = drawn.iter().map(|f| f.difference.pixels).sum();
            let same = pixels - drawn.iter().map(|f| f.difference.words).sum::<u64>();
            table.push(vec![
                name(precision).into(),
                name(shape).into(),
                all.len().into(),
                (all.len() - drawn.len()).into(),
                all.iter().filter(|f| f.outcome.is_ok() && f.holds()).count().into(),
                pixels.into(),
                format!("{:.2} %", 100.0 * same as f64 / pixels.max(1) as f64).into(),
                most(|f| f.off, &drawn).into(),
                most(|f| f.grid_error, &proved).into(),
                most(|f| f.refined_error, &proved).into(),
                proved.iter().map(|f| f.failures).sum::<u64>().into(),
            ]);
        }
    }
    table
}

fn table(found: &[Finding], broken: bool, stamped: &[Cell]) -> Table {
    let headings = [
        "model",
        "projection",
        "bound",
        "precision",
        "frame",
        "drawn",
        "words",
        "patches",
        "colours",
        "off",
        "failures",
        "CPU's failures",
        "grid error px",
        "refined px",
        "holds",
        "note",
    ];
    let stamp = if stamped.is_empty() { &[][..] } else { &STAMP };
    let mut table = Table::new(&[&headings[..], stamp].concat());
    for finding @ Finding { model, case, outcome } in found {
        let found = outcome.as_ref().ok();
        let precision = case.options.precision;
        if broken && finding.holds() {
            continue;
        }
        let count = |get: fn(&Found) -> u64| Cell::from(found.map(get));
        let cells = [
            model.as_str().into(),
            if case.orthographic { "orthographic" } else { "perspective" }.into(),
            name(case.options.bound).into(),
            name(precision).into(),
            name(case.options.frame).into(),
            count(|f| f.difference.drawn),
            count(|f| f.difference.words),
            count(|f| f.difference.patches),
            count(|f| f.difference.colors),
            found.and_then(|f| f.off).into(),
            count(|f| f.failures),
            count(|f| f.cpu_failures),
            found.and_then(|f| f.grid_error).into(),
            found.and_then(|f| f.refined_error).into(),
            if !finding.holds() {
                "NO"
            } else if found.is_some() {
                "yes"
            } else {
                ""
            }
            .into(),
            outcome.as_ref().err().map_or(String::new(), Refused::note).into(),
        ];
        table.push(cells.into_iter().chain(stamped.iter().cloned()).collect());
    }
    table
}
