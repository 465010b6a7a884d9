//! Software, hybrid and hardware rasterising of the same frames: ETER's figure 8, and from which size of a quad on hardware is
//! worth it on this device.

use super::{Findings, ResultArgs};
use crate::commands::args::FrameArgs;
use crate::commands::backend::vulkan_missing;
use crate::commands::measure::{Effort, Subject};
use crate::commands::output;
use crate::cuda::Gpu;
use crate::report::{Cell, Row, Table, name};
use crate::stages::{Bound, Engine, Frame, FrameShape, Grid, Options, Raster, RenderError, Renderer};
use crate::vulkan::{Found, threshold};
use anyhow::{Context, Result, bail, ensure};

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub effort: Effort,
    /// Do not keep what was found for later frames of --raster hybrid
    #[arg(long)]
    pub forget: bool,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// Pixels along a quad's longer side that are tried.
const SIDES: [f64; 9] = [4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 64.0, 128.0, NEVER];
/// No quad is as long: where hardware is of no use.
const NEVER: f64 = 1e9;

/// Where rows are: software by our grids, hardware, software by ETER's with no triangle of more than 16 pixels (its equation 2),
/// and hybrid by `SIDES`.
const SOFTWARE: usize = 0;
const HARDWARE: usize = 1;
const SOFTWARE16: usize = 2;
const HYBRID: usize = 3;

/// Rows of one model.
struct Finding {
    rows: Vec<Row>,
    /// Pixels of each row that are not software's in the same grids and shape; None: it is software's.
    different: Vec<Option<u64>>,
}

pub fn run(args: &Args) -> Result<()> {
    let missing = vulkan_missing();
    if !missing.is_empty() {
        bail!("rasterisers can't be compared: {}", missing.join("; "));
    }
    let mut found = Vec::new();
    let mut device = None;
    args.frame.model.install(|| {
        for model in args.frame.model.each() {
            let (loaded, scene) = model.load_scene()?;
            let view = args.frame.view_spec();
            let all = configurations(&args.frame.options());
            let mut subject = Subject::new(&loaded.name, &scene, args.effort, args.frame.backend.engine()?);
            let rows = subject.rows(&view, &all)?;
            // The same pixels are drawn, or the comparison says nothing.
            let camera = args.frame.camera(&scene)?;
            let mut renderer = Renderer::with(&scene, args.frame.backend.engine()?);
            let software = renderer.render(&camera, &all[SOFTWARE]);
            let mut different = Vec::new();
            for options in &all {
                let by_hardware = options.raster.is_hardware().then(|| renderer.render(&camera, options));
                different.push(by_hardware.map(|frame| words(&software, &frame)));
            }
            device = renderer.rasterizer().map(|r| r.device().found.clone()).or(device.take());
            found.push(Finding { rows, different });
        }
        Ok(())
    })?;
    let device = device.context("no frame was drawn by hardware")?;
    let best = best(&found);
    let engine = args.frame.backend.engine()?;
    let kept = match best.filter(|_| !args.forget) {
        Some(pixels) => match threshold::store(&device, engine.name(), args.frame.route, pixels) {
            Ok(path) => format!("kept in {}", path.display()),
            Err(error) => {
                output::warning_line(&format!("the threshold can't be kept: {error}"));
                "not kept".into()
            }
        },
        None => "not kept".into(),
    };
    let tables = vec![
        ("Rasterisers (ETER's figure 8)".into(), rasterisers(&found)),
        ("Hybrid by the size of quads that hardware gets".into(), sides(&found)),
    ];
    let different: u64 = found.iter().flat_map(|f| &f.different).flatten().sum();
    let verdict = if different == 0 { "Every frame stores the same words." } else { "SOME FRAMES STORE OTHER WORDS." };
    let about = format!("{} {verdict}", about(args, &device, best, &kept));
    let copied = found.iter().flat_map(|f| &f.rows).filter_map(Row::measured).map(|m| m.counts.bytes_copied).max();
    let rows = found.into_iter().flat_map(|f| f.rows).collect();
    Findings { title: "Rasterisers", about, tables, rows }.publish(&args.results)?;
    ensure!(different == 0, "{different} pixels are not software's");
    let shares = matches!(&engine, Engine::Cuda(stream) if Some(device.uuid.as_str()) == stream.vulkan_uuid());
    let needless = copied.filter(|&bytes| bytes > 0 && shares && device.absent.is_empty());
    ensure!(needless.is_none(), "{} bytes a frame were copied within one device", needless.unwrap_or_default());
    Ok(())
}

fn configurations(ours: &Options) -> Vec<Options> {
    // All in one shape: in another, other stages evaluate vertices, and other arithmetic.
    let frame = FrameShape::Staged;
    let by = |raster| Options { raster, frame, ..*ours };
    let hybrid = SIDES.map(|side| Options { large: Some(side), ..by(Raster::Hybrid) });
    let eter = Options { bound: Bound::Eter, grid: Grid::Eter16, ..by(Raster::Software) };
    [by(Raster::Software), by(Raster::Hardware), eter].into_iter().chain(hybrid).collect()
}

/// How many pixels of two frames are not alike: none where both are refused, all where one is.
fn words(software: &Result<Frame, RenderError>, hardware: &Result<Frame, RenderError>) -> u64 {
    match (software, hardware) {
        (Ok(a), Ok(b)) => super::backends::Difference::of(a, b).words,
        (Err(_), Err(_)) => 0,
        (Ok(frame), Err(_)) | (Err(_), Ok(frame)) => frame.size().into_iter().map(u64::from).product(),
    }
}

/// Rasterising, whatever stage does it.
fn raster_ms(row: &Row) -> Option<f64> {
    row.measured().map(|m| m.stage("rasterize") + m.stage("trim"))
}

/// The side with which all models together take least.
fn best(found: &[Finding]) -> Option<f64> {
    let all = SIDES.iter().enumerate().map(|(k, &side)| {
        // What one model was refused with is no choice.
        let sum: f64 = found.iter().map(|f| raster_ms(&f.rows[HYBRID + k]).unwrap_or(f64::INFINITY)).sum();
        (side, sum)
    });
    all.filter(|(_, sum)| sum.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(side, _)| side)
}

fn rasterisers(found: &[Finding]) -> Table {
    let mut table = Table::new(&[
        "model",
        "raster",
        "grid",
        "frame",
        "quads from px",
        "ms",
        "least ms",
        "rasterize + trim ms",
        "triangles",
        "by hardware",
        "copied bytes",
        "pixels not software's",
        "grid max px",
        "refined max px",
        "violations",
        "cracks",
    ]);
    let best = best(found);
    for Finding { rows, different } in found {
        let hybrid = best.and_then(|best| SIDES.iter().position(|&side| side == best)).map(|k| HYBRID + k);
        for k in [Some(SOFTWARE), Some(SOFTWARE16), hybrid, Some(HARDWARE)].into_iter().flatten() {
            let (row, m, e) = (&rows[k], rows[k].measured(), rows[k].errors());
            table.push(vec![
                row.model.as_str().into(),
                row.raster.as_str().into(),
                name(row.setting.grid).into(),
                row.frame.map_or_else(String::new, name).into(),
                (k >= HYBRID).then_some(best).flatten().map(pixels).into(),
                m.map(|m| m.total.median).into(),
                m.map(|m| m.total.min).into(),
                raster_ms(row).into(),
                m.map(|m| m.counts.triangles).into(),
                m.map(|m| m.counts.triangles_hardware).into(),
                m.map(|m| m.counts.bytes_copied).into(),
                different[k].into(),
                e.and_then(|e| e.grid_max()).into(),
                e.and_then(|e| e.refined).map(|s| s.max).into(),
                e.map(|e| e.violations).into(),
                e.map(|e| e.cracks).into(),
            ]);
        }
    }
    table
}

fn sides(found: &[Finding]) -> Table {
    let mut table =
        Table::new(&["model", "quads from px", "rasterize + trim ms", "by hardware", "pixels not software's"]);
    for Finding { rows, different } in found {
        for (k, side) in SIDES.into_iter().enumerate() {
            let row = &rows[HYBRID + k];
            table.push(vec![
                row.model.as_str().into(),
                pixels(side).into(),
                raster_ms(row).into(),
                row.measured().map(|m| m.counts.triangles_hardware).into(),
                Cell::from(different[HYBRID + k]),
            ]);
        }
    }
    table
}

/// From which side of a quad on.
fn pixels(side: f64) -> String {
    if side < NEVER { side.to_string() } else { "never".into() }
}

fn about(args: &Args, device: &Found, best: Option<f64>, kept: &str) -> String {
    let [width, height] = args.frame.size;
    let what = if device.kind == "cpu" {
        "a driver that draws on the CPU: its times say nothing about a GPU"
    } else {
        "data-centre GPUs have few graphics units, and their times say little about others"
    };
    let best = best.map_or("none".into(), pixels);
    format!(
        "{width}x{height}, frames by turns. Hardware: {} ({}, {}), {what}. Where all models together take least, hybrid gives \
         hardware the leaves with quads of so many pixels and more: {best} ({kept}).",
        device.name, device.kind, device.driver
    )
}
