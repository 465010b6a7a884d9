//! ETER's table 3: patches evaluated by the hardware's tessellation pipeline, beside mesh shaders that read what was evaluated
//! before; triangles are discarded.

use super::ResultArgs;
use super::kernels::Errors;
use super::kernels::nets::{Kind, Nets, VERTICES};
use super::sheet::{STAMP, Sheet, stamp};
use crate::commands::backend::vulkan_missing;
use crate::cuda::abi;
use crate::report::{Cell, Machine, Spread, Table};
use crate::vulkan::{
    Device, EdgeFactors, Evaluated, Found, Parameters, Tessellation, Tessellator, Validation, with_factor,
};
use anyhow::{Result, bail};

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Patches a degree [default: 20000 on a GPU, else 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub patches: Option<u32>,
    /// Degrees in u and v
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_values_t = [3, 4, 5, 6, 7],
          value_parser = clap::value_parser!(u8).range(1..=15))]
    pub degrees: Vec<u8>,
    /// Timed rounds, after one that warms up
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: u32,
    /// Pixels across a patch, for errors
    #[arg(long, value_name = "PIXELS", default_value_t = 1000.0, value_parser = super::super::args::parse_width)]
    pub width: f64,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// The tessellation factor of the paper's table: 65 x 65 vertices a patch, where mesh shaders read 64 x 64.
const FACTOR: u16 = 64;
/// Patches whose errors are looked at.
const SAMPLE: usize = 16;
/// The pixels are those of no image: nothing is rasterised.
const SIZE: [u32; 2] = [1024, 1024];

/// One way on patches of one degree.
struct Timing {
    degree: u8,
    what: &'static str,
    vertices: usize,
    ms: Spread,
    /// Where anything is evaluated.
    errors: Option<Errors>,
}

pub fn run(args: &Args) -> Result<()> {
    let missing = vulkan_missing();
    if !missing.is_empty() {
        bail!("nothing can be tessellated here: {}", missing.join("; "));
    }
    let mut tessellator = Tessellator::new(Device::new(Validation::Off, None)?)?;
    let found = tessellator.device().found.clone();
    let real = found.kind != "cpu";
    let patches = args.patches.unwrap_or(if real { 20_000 } else { 20 }) as usize;
    let mut timings = Vec::new();
    for &degree in &args.degrees {
        let nets = Nets::new(Kind { degree, width: args.width, ..Kind::default() }, patches);
        measure(&mut tessellator, &nets, args.rounds, &mut timings)?;
    }
    let machine =
        Machine { device: format!("{} ({})", found.name, found.driver), ..Machine::here(rayon::current_num_threads()) };
    let backend = "vulkan";
    let sheet = Sheet {
        suite: "tessellation",
        title: "Evaluation by hardware tessellation (ETER, table 3)",
        about: about(patches, args.width, &found),
        tables: vec![("Milliseconds".into(), table(&timings, real, &[]))],
        rows: table(&timings, real, &stamp(backend, &machine)),
        backend,
        machine,
    };
    sheet.publish(&args.results)
}

fn measure(tessellator: &mut Tessellator, nets: &Nets, rounds: u32, timings: &mut Vec<Timing>) -> Result<()> {
    let degree = nets.kind.degree;
    let patches = with_factor(&nets.surfaces.patches, FACTOR);
    let vertices = patches.len() * (usize::from(FACTOR) + 1).pow(2);
    for (what, parameters) in [
        ("tessellation, the grid's parameters", Parameters::Exact),
        ("tessellation, the hardware's parameters", Parameters::Hardware),
    ] {
        let of = |patches| Tessellation {
            size: SIZE,
            view: &nets.view,
            patches,
            nets: &nets.surfaces.nets,
            factors: EdgeFactors::Own,
            parameters,
        };
        let ms = tessellator.time(&of(&patches[..]), rounds)?;
        let errors = Some(errors(tessellator, nets, &of(&patches[..SAMPLE.min(patches.len())]))?);
        timings.push(Timing { degree, what, vertices, ms, errors });
    }
    let points = vec![abi::SurfacePoint { position: [1.0, 2.0, 0.5], normal: [0.0, 0.0, 1.0] }; VERTICES];
    let (patches, meshlets) = (&nets.surfaces.patches, &nets.surfaces.meshlets);
    let ms = tessellator.time_meshlets(&Evaluated { size: SIZE, patches, meshlets, points: &points }, rounds)?;
    let vertices = nets.len() * VERTICES;
    timings.push(Timing { degree, what: "mesh shader, reads points and normals", vertices, ms, errors: None });
    Ok(())
}

/// Pixels between vertices and f64, each where the grid has it.
fn errors(tessellator: &mut Tessellator, nets: &Nets, input: &Tessellation) -> Result<Errors> {
    let found = tessellator.evaluate(input)?;
    let mut all = Vec::new();
    for (k, piece) in found.pieces.iter().enumerate() {
        for sample in found.samples(k) {
            // What the hardware's own parameters are off by counts too.
            let line = sample.parameters.map(|t| f64::from(t * f32::from(FACTOR)).round() / f64::from(FACTOR));
            let exact = nets.point(piece.patch as usize, line);
            all.push(nets.off_in_space([sample.position[0], sample.position[1], 0.0], exact));
        }
    }
    Ok(Errors::of(all))
}

fn about(patches: usize, width: f64, found: &Found) -> String {
    let device = if found.kind == "cpu" {
        "THE DEVICE IS A CPU: its times say nothing about a GPU"
    } else {
        "data-centre GPUs have few graphics units, and their times say little about others"
    };
    format!(
        "{patches} patches a degree (the paper: 20000), factor {FACTOR}, rasteriser discard, times on the device's clock. \
         Tessellation evaluates points and unit normals by Mann and DeRose's scheme; what a mesh shader reads, kernels have \
         evaluated before (`bench evaluate` has their times), so that a row of it and one of `evaluate` together are what the \
         paper compares. Errors against f64, of {SAMPLE} patches at most, where one is {width} px across. Device: {} ({}, {}); \
         {device}.",
        found.name, found.kind, found.driver
    )
}

fn table(timings: &[Timing], real: bool, stamped: &[Cell]) -> Table {
    let headings =
        ["degree", "what", "ms", "least ms", "largest ms", "vertices", "10^9/s", "max px", "p999 px", "mean px"];
    let stamp = if stamped.is_empty() { &[][..] } else { &STAMP };
    let mut table = Table::new(&[&headings[..], stamp].concat());
    for Timing { degree, what, vertices, ms, errors } in timings {
        let cells = [
            u64::from(*degree).into(),
            (*what).into(),
            ms.median.into(),
            ms.min.into(),
            ms.max.into(),
            (*vertices as u64).into(),
            real.then(|| *vertices as f64 * 1e-6 / ms.median).into(),
            errors.map(|e| e.max).into(),
            errors.map(|e| e.p999).into(),
            errors.map(|e| e.mean).into(),
        ];
        table.push(cells.into_iter().chain(stamped.iter().cloned()).collect());
    }
    table
}
