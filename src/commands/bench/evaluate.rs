//! ETER's table 1: points on a grid of 64 x 64 by every kernel of evaluate, degrees 3 to 7; the time of each beside its error.

use super::kernels::floors::Floors;
use super::kernels::nets::{Kind, MESHLETS, Nets, VERTICES};
use super::kernels::{Bench, Candidate, DeviceArgs, Errors, Ground, Output};
use super::sheet::{STAMP, Sheet, stamp};
use super::{ResultArgs, targets};
use crate::commands::output;
use crate::cuda::measured::{self, Times};
use crate::cuda::precision::{Arithmetic, LARGEST_TENSOR_DEGREE};
use crate::cuda::{Gpu, GpuError};
use crate::report::{Cell, Spread, Table};
use crate::stages::Engine;
use anyhow::Result;

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Patches a degree [default: 20000 on a GPU, else 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub patches: Option<u32>,
    /// Degrees in u and v
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_values_t = [3, 4, 5, 6, 7],
          value_parser = clap::value_parser!(u8).range(1..=i64::from(LARGEST_TENSOR_DEGREE)))]
    pub degrees: Vec<u8>,
    /// Pixels across a patch, for errors in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1000.0, value_parser = super::super::args::parse_width)]
    pub width: f64,
    /// Do not keep a GPU's times for later frames of --precision auto
    #[arg(long)]
    pub forget: bool,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// One kernel on patches of one degree.
struct Timing {
    degree: u8,
    candidate: Candidate,
    ms: Spread,
    errors: Errors,
}

/// What a device found.
struct Found {
    floors: Floors,
    timings: Vec<Timing>,
}

/// Patches whose errors are looked at.
const SAMPLE: usize = 64;

pub fn run(args: &Args) -> Result<()> {
    let (engine, ground) = args.device.engine()?;
    let patches = args.patches.unwrap_or(if ground.real { 20_000 } else { 20 }) as usize;
    let found = match engine {
        Engine::Cuda(mut stream) => measure(&mut ground.bench(&mut *stream), args, &ground, patches)?,
        Engine::Emulated(mut device) => measure(&mut ground.bench(&mut *device), args, &ground, patches)?,
        Engine::Cpu => unreachable!("refused before"),
    };
    let kept = keep(args, &found, &ground, patches);
    let verdict = targets::evaluation(&over_floor(&found, patches), ground.real);
    let sheet = Sheet {
        suite: "evaluate",
        title: "Evaluation (ETER, table 1)",
        about: about(args, &ground, patches) + &kept,
        tables: vec![
            ("What a GPU must reach".into(), targets::table(&[verdict])),
            (format!("As ETER's table 1: {} for points and normals", ground.ms()), like_eter(&found.timings)),
            ("Kernels".into(), brief(&found, &ground, patches, args.width)),
            ("What the device does at most".into(), found.floors.table(ground.real)),
        ],
        rows: rows(&found, &ground, patches, args.width),
        backend: ground.backend,
        machine: ground.machine,
    };
    sheet.publish(&args.results)
}

fn about(args: &Args, ground: &Ground, patches: usize) -> String {
    format!(
        "{patches} patches a degree, {} vertices each in {MESHLETS} meshlets: {:.2} million ({}). Errors against f64, of the \
         first {SAMPLE} patches at most: over the patch's extent, in ulp of it (2^-23), and in pixels where a patch is {} px \
         across. Floors: what storing as many bytes, and the least arithmetic alone, take at rates measured in this run; the \
         share is a floor over the time. {}",
        VERTICES,
        (patches * VERTICES) as f64 * 1e-6,
        if patches == 20_000 { "as in the paper" } else { "the paper: 81.92" },
        args.width,
        ground.caveat()
    )
}

/// Keeps a GPU's times; what is said of that.
fn keep(args: &Args, found: &Found, ground: &Ground, patches: usize) -> String {
    if !ground.real {
        return String::new();
    }
    if args.forget {
        return " They are not kept.".into();
    }
    let times = times(&found.timings, patches);
    let stored =
        measured::file().and_then(|file| measured::store(&file, &ground.machine.device, &times).map(|()| file));
    match stored {
        Ok(file) => format!(" They are kept in {} for later frames of --precision auto.", file.display()),
        Err(error) => {
            output::warning_line(&format!("the times can't be kept: {error}"));
            " They are not kept.".into()
        }
    }
}

/// Of the kernels that make the frame's vertices.
fn times(timings: &[Timing], patches: usize) -> Times {
    let mut times = Times::new();
    for t in timings.iter().filter(|t| t.candidate.output == Output::Vertex) {
        let nanoseconds = t.ms.median * 1e6 / (patches * MESHLETS) as f64;
        times.entry(t.candidate.arithmetic).or_default().insert(t.degree, nanoseconds);
    }
    times
}

fn measure<G: Gpu>(bench: &mut Bench<G>, args: &Args, ground: &Ground, patches: usize) -> Result<Found, GpuError> {
    // Loops of milliseconds on a GPU.
    let floors = bench.floors(patches * VERTICES * Output::Point.bytes(), if ground.real { 8192 } else { 16 })?;
    let mut timings = Vec::new();
    for &degree in &args.degrees {
        let nets = Nets::new(Kind { degree, width: args.width, ..Kind::default() }, patches);
        let on = bench.upload(&nets, SAMPLE)?;
        for candidate in candidates(degree) {
            let ms = bench.time(&on, &candidate)?;
            let errors = bench.errors(&on, &candidate)?;
            timings.push(Timing { degree, candidate, ms, errors });
        }
        bench.free(on)?;
    }
    Ok(Found { floors, timings })
}

/// Every kernel that evaluates patches of a degree.
fn candidates(degree: u8) -> Vec<Candidate> {
    let of = |kernel: String, arithmetic, output| Candidate { kernel, arithmetic, output };
    // Unrolled for the degrees of ETER's table.
    let unrolled = |kernel: &str| if degree < 3 { kernel.into() } else { format!("{kernel}_d{degree}") };
    let points = |kernel: String, arithmetic| of(kernel, arithmetic, Output::Point);
    let frames = |kernel: &str, arithmetic| of(kernel.into(), arithmetic, Output::Frame);
    let normals = |arithmetic| points(format!("evaluate_normals_{}", word(arithmetic)), arithmetic);
    let mut all = vec![
        points(unrolled("evaluate_eter"), Arithmetic::F32),
        points(unrolled("evaluate_normals_f32"), Arithmetic::F32),
    ];
    all.extend(Arithmetic::ALL.into_iter().filter(|&a| a != Arithmetic::F32).map(normals));
    all.push(frames("evaluate_tangents_f32", Arithmetic::F32));
    all.push(frames("evaluate_tangents_f16_recovered", Arithmetic::F16Recovered));
    all.extend(Arithmetic::ALL.map(|a| of(a.kernel([degree; 2]).to_string(), a, Output::Vertex)));
    all
}

/// As kernels are named.
pub(super) fn word(arithmetic: Arithmetic) -> String {
    let kernel = arithmetic.kernel([1, 2]).to_string();
    kernel.trim_start_matches("evaluate_").into()
}

/// Degrees across, kernels for points and normals down.
fn like_eter(timings: &[Timing]) -> Table {
    let mut degrees: Vec<u8> = timings.iter().map(|t| t.degree).collect();
    degrees.dedup();
    let headings: Vec<String> =
        std::iter::once("surface degree".into()).chain(degrees.iter().map(u8::to_string)).collect();
    let mut table = Table::new(&headings.iter().map(String::as_str).collect::<Vec<_>>());
    let general = |t: &Timing| t.candidate.kernel.trim_end_matches(&format!("_d{}", t.degree)).to_owned();
    let points = || timings.iter().filter(|t| t.candidate.output == Output::Point);
    let mut kernels: Vec<String> = Vec::new();
    points().map(general).for_each(|kernel| {
        if !kernels.contains(&kernel) {
            kernels.push(kernel);
        }
    });
    for kernel in kernels {
        let ms = |&degree: &u8| points().find(|t| t.degree == degree && general(t) == kernel).map(|t| t.ms.median);
        let cells = degrees.iter().map(|degree| Cell::from(ms(degree)));
        table.push(std::iter::once(Cell::from(kernel.as_str())).chain(cells).collect());
    }
    table
}

/// Floors of a timing in ms: of storing, of arithmetic.
fn floors(found: &Found, timing: &Timing, patches: usize) -> [f64; 2] {
    let bytes = (patches * VERTICES * timing.candidate.output.bytes()) as f64;
    let meshlets = (patches * MESHLETS) as f64;
    [found.floors.store_ms(bytes), found.floors.arithmetic_ms(&timing.candidate, timing.degree, meshlets)]
}

/// Kernels that make the frame's vertices: degree, arithmetic, time over the store floor.
fn over_floor(found: &Found, patches: usize) -> Vec<(u8, Arithmetic, f64)> {
    let vertices = found.timings.iter().filter(|t| t.candidate.output == Output::Vertex);
    vertices.map(|t| (t.degree, t.candidate.arithmetic, t.ms.median / floors(found, t, patches)[0])).collect()
}

fn brief(found: &Found, ground: &Ground, patches: usize, width: f64) -> Table {
    let mut table = Table::new(&[
        "degree",
        "kernel",
        ground.ms(),
        "Gvertex/s",
        "B a vertex",
        "store floor",
        "arithmetic floor",
        "error / extent",
        "ulp",
        "px",
        "p999 px",
    ]);
    for t in &found.timings {
        let [store, arithmetic] =
            floors(found, t, patches).map(|floor| ground.real.then(|| percent(floor / t.ms.median)));
        table.push(vec![
            u64::from(t.degree).into(),
            t.candidate.kernel.as_str().into(),
            t.ms.median.into(),
            ground.rate(patches * VERTICES, t.ms.median).into(),
            t.candidate.output.bytes().into(),
            store.into(),
            arithmetic.into(),
            format!("{:.1e}", t.errors.max / width).into(),
            (t.errors.max / width * ULPS).into(),
            t.errors.max.into(),
            t.errors.p999.into(),
        ]);
    }
    table
}

/// Ulps of 1 in f32.
const ULPS: f64 = (1 << 23) as f64;

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn rows(found: &Found, ground: &Ground, patches: usize, width: f64) -> Table {
    let headings = [
        "degree",
        "kernel",
        "arithmetic",
        "output",
        "bytes_a_vertex",
        "patches",
        "vertices",
        "repeats",
        "timed_by",
        "ms",
        "min_ms",
        "max_ms",
        "store_floor_ms",
        "arithmetic_floor_ms",
        "error_max_of_extent",
        "error_max_ulp",
        "width_px",
        "error_max_px",
        "error_p999_px",
        "error_mean_px",
    ];
    let mut table = Table::new(&[&headings[..], &STAMP].concat());
    for t in &found.timings {
        let [store, arithmetic] = floors(found, t, patches);
        let cells = [
            u64::from(t.degree).into(),
            t.candidate.kernel.as_str().into(),
            word(t.candidate.arithmetic).into(),
            t.candidate.output.name().into(),
            t.candidate.output.bytes().into(),
            patches.into(),
            (patches * VERTICES).into(),
            u64::from(ground.repeats).into(),
            ground.timed_by().into(),
            t.ms.median.into(),
            t.ms.min.into(),
            t.ms.max.into(),
            store.into(),
            arithmetic.into(),
            (t.errors.max / width).into(),
            (t.errors.max / width * ULPS).into(),
            width.into(),
            t.errors.max.into(),
            t.errors.p999.into(),
            t.errors.mean.into(),
        ];
        table.push(cells.into_iter().chain(stamp(ground.backend, &ground.machine)).collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_nanoseconds_a_meshlet_of_the_kernels_of_frames() {
        let all = candidates(4).into_iter().enumerate().map(|(k, candidate)| {
            let ms = Spread { median: (k + 1) as f64, ..Spread::default() };
            Timing { degree: 4, candidate, ms, errors: Errors::default() }
        });
        let all: Vec<Timing> = all.collect();
        let times = times(&all, 1000);
        assert!(times.keys().copied().eq(Arithmetic::ALL), "{times:?}");
        // The last kernels are those.
        let slowest = all.len() as f64 * 1e6 / (1000 * MESHLETS) as f64;
        assert_eq!(times[&Arithmetic::Tf32Recovered], [(4, slowest)].into());
    }
}
