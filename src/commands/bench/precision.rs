//! Error against time of every arithmetic that a frame can be evaluated in, over the hard cases.

use super::ResultArgs;
use super::evaluate::word;
use super::kernels::nets::{Kind, Nets, VERTICES};
use super::kernels::{Bench, Candidate, DeviceArgs, Errors, Ground, Output};
use super::sheet::{STAMP, Sheet, stamp};
use crate::cuda::precision::{Arithmetic, LARGEST_TENSOR_DEGREE};
use crate::cuda::{Gpu, GpuError};
use crate::report::{Spread, Table};
use crate::stages::Engine;
use anyhow::Result;

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Patches a case [default: 20000 on a GPU, else 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub patches: Option<u32>,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// One arithmetic on one case.
struct Finding {
    case: String,
    kind: Kind,
    arithmetic: Arithmetic,
    kernel: String,
    ms: Spread,
    errors: Errors,
    /// Largest a-priori bound of the patches that were looked at, px.
    bound: f64,
    /// Largest part of its own patch's bound that an error reached, snapping taken off.
    reached: f64,
}

/// Patches whose errors are looked at.
const SAMPLE: usize = 64;
/// What tensor cores do not do.
const LARGE_DEGREE: u8 = 22;

pub fn run(args: &Args) -> Result<()> {
    let (engine, ground) = args.device.engine()?;
    let patches = args.patches.unwrap_or(if ground.real { 20_000 } else { 4 }) as usize;
    let found = match engine {
        Engine::Cuda(mut stream) => measure(&mut ground.bench(&mut *stream), patches)?,
        Engine::Emulated(mut device) => measure(&mut ground.bench(&mut *device), patches)?,
        Engine::Cpu => unreachable!("refused before"),
    };
    let sheet = Sheet {
        suite: "precision",
        title: "Error against time of every arithmetic",
        about: format!(
            "{patches} patches a case of {VERTICES} vertices, evaluated and projected; bicubic, 1000 px across, weights of 1, \
             orthographic, where the case says nothing else. Errors in x or y before snapping against f64, of the first \
             {SAMPLE} patches at most. The bound is the a-priori one of src/cuda/precision.rs; nothing may exceed it, but \
             patches that are not centred have numbers that differ before they are evaluated. {}",
            ground.caveat()
        ),
        tables: vec![("Cases".into(), brief(&found, &ground, patches))],
        rows: rows(&found, &ground, patches),
        backend: ground.backend,
        machine: ground.machine,
    };
    sheet.publish(&args.results)
}

/// The hard cases: one property at a time.
fn cases() -> Vec<(String, Kind)> {
    let base = Kind::default();
    let mut cases: Vec<(String, Kind)> = (1..=LARGEST_TENSOR_DEGREE)
        .chain([LARGE_DEGREE])
        .map(|degree| (format!("degree {degree}"), Kind { degree, ..base }))
        .collect();
    cases.extend([10.0, 1e3].map(|weights| (format!("weights 1/{weights} to {weights}"), Kind { weights, ..base })));
    let deep = Kind { perspective: true, weights: 10.0, ..base };
    cases.push(("perspective, weights 1/10 to 10".into(), deep));
    let widths = [1.0, 10.0, 100.0, 10_000.0];
    cases.extend(widths.map(|width| (format!("{width} px across"), Kind { width, ..base })));
    let far = Kind { offset: 1e6, ..base };
    cases.push(("1e6 widths off the origin".into(), far));
    cases.push(("1e6 widths off the origin, not centred".into(), Kind { centred: false, ..far }));
    cases
}

fn measure<G: Gpu>(bench: &mut Bench<G>, patches: usize) -> Result<Vec<Finding>, GpuError> {
    let mut found = Vec::new();
    for (case, kind) in cases() {
        let nets = Nets::new(kind, patches);
        let on = bench.upload(&nets, SAMPLE)?;
        // What tensor cores don't do is done in f32, once.
        let own = Arithmetic::ALL.into_iter().filter(|a| a.for_degree([kind.degree; 2]) == *a);
        for arithmetic in own {
            let kernel = arithmetic.kernel([kind.degree; 2]).to_string();
            let candidate = Candidate { kernel, arithmetic, output: Output::Vertex };
            let ms = bench.time(&on, &candidate)?;
            let by_patch = bench.errors_by_patch(&on, &candidate)?;
            let bounds: Vec<f64> = (0..by_patch.len())
                .map(|patch| {
                    let (hull, pixel) = nets.hull(patch);
                    arithmetic.bound(&hull).place * pixel
                })
                .collect();
            let part = |(errors, bound): (&Vec<f64>, &f64)| {
                let largest = errors.iter().copied().fold(0.0, f64::max);
                (largest - nets.snapping()).max(0.0) / bound
            };
            found.push(Finding {
                case: case.clone(),
                kind,
                arithmetic,
                kernel: candidate.kernel,
                ms,
                bound: bounds.iter().copied().fold(0.0, f64::max),
                reached: by_patch.iter().zip(&bounds).map(part).fold(0.0, f64::max),
                errors: Errors::of(by_patch.into_iter().flatten().collect()),
            });
        }
        bench.free(on)?;
    }
    Ok(found)
}

fn brief(found: &[Finding], ground: &Ground, patches: usize) -> Table {
    let mut table = Table::new(&[
        "case",
        "kernel",
        ground.ms(),
        "Gvertex/s",
        "px",
        "p999 px",
        "error / extent",
        "bound px",
        "of the bound",
    ]);
    for f in found {
        table.push(vec![
            f.case.as_str().into(),
            f.kernel.as_str().into(),
            f.ms.median.into(),
            ground.rate(patches * VERTICES, f.ms.median).into(),
            f.errors.max.into(),
            f.errors.p999.into(),
            format!("{:.1e}", f.errors.max / f.kind.width).into(),
            f.bound.into(),
            f.reached.into(),
        ]);
    }
    table
}

fn rows(found: &[Finding], ground: &Ground, patches: usize) -> Table {
    let headings = [
        "case",
        "degree",
        "weights",
        "width_px",
        "offset_widths",
        "centred",
        "perspective",
        "arithmetic",
        "kernel",
        "patches",
        "vertices",
        "repeats",
        "timed_by",
        "ms",
        "min_ms",
        "max_ms",
        "error_max_px",
        "error_p999_px",
        "error_mean_px",
        "error_max_of_extent",
        "bound_px",
        "largest_part_of_bound",
    ];
    let mut table = Table::new(&[&headings[..], &STAMP].concat());
    for f in found {
        let Kind { degree, weights, width, offset, centred, perspective } = f.kind;
        let cells = [
            f.case.as_str().into(),
            u64::from(degree).into(),
            weights.into(),
            width.into(),
            offset.into(),
            u64::from(centred).into(),
            u64::from(perspective).into(),
            word(f.arithmetic).into(),
            f.kernel.as_str().into(),
            patches.into(),
            (patches * VERTICES).into(),
            u64::from(ground.repeats).into(),
            ground.timed_by().into(),
            f.ms.median.into(),
            f.ms.min.into(),
            f.ms.max.into(),
            f.errors.max.into(),
            f.errors.p999.into(),
            f.errors.mean.into(),
            (f.errors.max / width).into(),
            f.bound.into(),
            f.reached.into(),
        ];
        table.push(cells.into_iter().chain(stamp(ground.backend, &ground.machine)).collect());
    }
    table
}
