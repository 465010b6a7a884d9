//! Kernels of evaluate by themselves: timed beside what storing and arithmetic alone take, and compared with f64.

pub mod floors;
pub mod nets;

use crate::commands::UsageError;
use crate::commands::backend::{Backend, cuda_missing};
use crate::cuda::precision::Arithmetic;
use crate::cuda::{self, Argument, Buffer, Count, Gpu, GpuError, Pod, Pointer, Shape, abi};
use crate::report::{Machine, Spread};
use crate::stages::Engine;
use anyhow::Result;
use nets::{Nets, Point};
use rayon::prelude::*;

/// Threads a block of all kernels of evaluate, and meshlets a block of those that take a warp for each.
const THREADS: u32 = 128;
const WARPS: u32 = 4;
/// Blocks of ETER's persistent threads that fit on a multiprocessor: of 64 registers a thread, and 4352 bytes.
const PERSISTENT: u32 = 8;

/// What a kernel stores for a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Pixel, depth, weight.
    Vertex,
    /// Position and normal.
    Point,
    /// Position, both tangents, normal.
    Frame,
}

impl Output {
    pub fn bytes(self) -> usize {
        match self {
            Output::Vertex => size_of::<abi::Vertex>(),
            Output::Point => size_of::<abi::SurfacePoint>(),
            Output::Frame => size_of::<abi::SurfaceFrame>(),
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Output::Vertex => "projected vertex",
            Output::Point => "point, normal",
            Output::Frame => "point, tangents, normal",
        }
    }
}

/// A kernel to be timed.
#[derive(Clone, Debug)]
pub struct Candidate {
    pub kernel: String,
    pub arithmetic: Arithmetic,
    pub output: Output,
}

/// Pixels between vertices and where they belong.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    pub max: f64,
    pub p999: f64,
    pub mean: f64,
}

impl Errors {
    pub fn of(mut all: Vec<f64>) -> Self {
        all.sort_by(f64::total_cmp);
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let at = |part: f64| all.get(((all.len() as f64 * part) as usize).min(all.len().saturating_sub(1))).copied();
        Self { max: at(1.0).unwrap_or(0.0), p999: at(0.999).unwrap_or(0.0), mean }
    }
}

/// A device, and how to use it.
pub struct Bench<'g, G: Gpu> {
    pub gpu: &'g mut G,
    pub multiprocessors: u32,
    pub repeats: u32,
}

/// Nets on a device.
pub struct Resident<'n> {
    nets: &'n Nets,
    patches: Buffer<abi::Patch>,
    meshlets: Buffer<abi::Meshlet>,
    points: Buffer<abi::Point>,
    basis: Buffer<f32>,
    slopes: Buffer<f32>,
    /// In f64, of the first patches: what is compared.
    exact: Vec<Vec<Point>>,
}

impl<G: Gpu> Bench<'_, G> {
    /// Brings nets onto the device; the first `sample` patches are for errors.
    pub fn upload<'n>(&mut self, nets: &'n Nets, sample: usize) -> Result<Resident<'n>, GpuError> {
        let surfaces = &nets.surfaces;
        Ok(Resident {
            nets,
            patches: self.gpu.upload(&surfaces.patches)?,
            meshlets: self.gpu.upload(&surfaces.meshlets)?,
            points: self.gpu.upload(&surfaces.nets)?,
            basis: self.gpu.upload(&surfaces.basis)?,
            slopes: self.gpu.upload(&surfaces.slopes)?,
            exact: (0..sample.min(nets.len())).into_par_iter().map(|patch| nets.points(patch)).collect(),
        })
    }

    pub fn free(&mut self, on: Resident) -> Result<(), GpuError> {
        self.gpu.free(on.patches)?;
        self.gpu.free(on.meshlets)?;
        self.gpu.free(on.points)?;
        self.gpu.free(on.basis)?;
        self.gpu.free(on.slopes)
    }

    /// Times a kernel on all patches.
    pub fn time(&mut self, on: &Resident, candidate: &Candidate) -> Result<Spread, GpuError> {
        let out = self.gpu.allocate::<u32>(on.nets.surfaces.points * candidate.output.bytes() / size_of::<u32>())?;
        let count = on.meshlets.len() as u32;
        let times = self.timed(|bench| bench.launch(on, candidate, out.pointer(), count));
        self.gpu.free(out)?;
        times
    }

    /// Compares the first patches' vertices with f64.
    pub fn errors(&mut self, on: &Resident, candidate: &Candidate) -> Result<Errors, GpuError> {
        Ok(Errors::of(self.errors_by_patch(on, candidate)?.concat()))
    }

    /// Pixels that each vertex of the first patches is off.
    pub fn errors_by_patch(&mut self, on: &Resident, candidate: &Candidate) -> Result<Vec<Vec<f64>>, GpuError> {
        let nets = on.nets;
        Ok(match candidate.output {
            Output::Vertex => {
                let found = self.sample::<abi::Vertex>(on, candidate)?;
                on.compare(&found, |vertex, exact| nets.off_in_pixels(vertex, exact))
            }
            Output::Point => {
                let found = self.sample::<abi::SurfacePoint>(on, candidate)?;
                on.compare(&found, |point, exact| nets.off_in_space(point.position, exact))
            }
            Output::Frame => {
                let found = self.sample::<abi::SurfaceFrame>(on, candidate)?;
                on.compare(&found, |frame, exact| nets.off_in_space(frame.position, exact))
            }
        })
    }

    fn sample<T: Pod>(&mut self, on: &Resident, candidate: &Candidate) -> Result<Vec<T>, GpuError> {
        let out = self.gpu.allocate::<T>(on.exact.len() * nets::VERTICES)?;
        let words = Pointer::<u32>::new(out.pointer().bits);
        self.launch(on, candidate, words, (on.exact.len() * nets::MESHLETS) as u32)?;
        let found = self.gpu.download(&out)?;
        self.gpu.free(out)?;
        Ok(found)
    }

    /// Evaluates the first `count` meshlets.
    fn launch(&mut self, on: &Resident, what: &Candidate, out: Pointer<u32>, count: u32) -> Result<(), GpuError> {
        let blocks = if what.kernel.starts_with("evaluate_eter") {
            (PERSISTENT * self.multiprocessors).min(count)
        } else {
            count.div_ceil(WARPS)
        };
        let (patches, meshlets, points) = (on.patches.pointer(), on.meshlets.pointer(), on.points.pointer());
        let (basis, slopes) = (on.basis.pointer(), on.slopes.pointer());
        let all = Count::known(count);
        let arguments: [&dyn Argument; 7] = match what.output {
            Output::Vertex => [&on.nets.view, &patches, &meshlets, &points, &basis, &out, &all],
            _ => [&patches, &meshlets, &points, &basis, &slopes, &out, &count],
        };
        self.gpu.launch(&what.kernel, Shape::row(blocks, THREADS), &arguments)
    }

    /// Times something by the device's clock, after once to warm up.
    fn timed(&mut self, mut work: impl FnMut(&mut Self) -> Result<(), GpuError>) -> Result<Spread, GpuError> {
        work(self)?;
        let mut marks = vec![self.gpu.mark()?];
        for _ in 0..self.repeats {
            work(self)?;
            marks.push(self.gpu.mark()?);
        }
        self.gpu.finish()?;
        let times: Result<Vec<f64>, GpuError> = marks.windows(2).map(|m| self.gpu.between(&m[0], &m[1])).collect();
        Ok(Spread::of(times?))
    }
}

impl Resident<'_> {
    fn compare<T: Sync>(&self, found: &[T], off: impl Fn(&T, Point) -> f64 + Sync) -> Vec<Vec<f64>> {
        let patches = found.par_chunks(nets::VERTICES).zip(&self.exact);
        patches.map(|(found, exact)| found.iter().zip(exact).map(|(f, &e)| off(f, e)).collect()).collect()
    }
}

/// Where kernels run.
#[derive(Clone, Debug, clap::Args)]
pub struct DeviceArgs {
    /// What runs the kernels: cuda or emulated [default: cuda where there is a GPU]
    #[arg(long, value_enum, default_value_t)]
    pub backend: Backend,
    /// Timed launches a kernel, after one that warms up [default: 25 on a GPU, else 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeats: Option<u32>,
}

/// What a suite of kernels is given.
pub struct Ground {
    pub machine: Machine,
    pub backend: &'static str,
    pub multiprocessors: u32,
    pub repeats: u32,
    /// Times are those of the GPU, not of the CPU in its place.
    pub real: bool,
}

impl DeviceArgs {
    pub fn engine(&self) -> Result<(Engine, Ground)> {
        let backend = match self.backend {
            Backend::Auto if cuda_missing().is_empty() => Backend::Cuda,
            Backend::Auto => Backend::Emulated,
            Backend::Cpu => {
                return Err(UsageError("--backend cpu runs no kernels: give cuda or emulated".into()).into());
            }
            named => named,
        };
        let engine = backend.engine()?;
        let real = engine.gpu().is_some();
        let mut machine = Machine::here(rayon::current_num_threads());
        machine.device = engine.gpu().unwrap_or(machine.device);
        let first = cuda::devices().ok().filter(|_| real).and_then(|devices| devices.into_iter().next());
        let ground = Ground {
            machine,
            backend: engine.name(),
            multiprocessors: first.map_or(1, |d| d.multiprocessors.unsigned_abs()),
            repeats: self.repeats.unwrap_or(if real { 25 } else { 1 }),
            real,
        };
        Ok((engine, ground))
    }
}

impl Ground {
    pub fn bench<'g, G: Gpu>(&self, gpu: &'g mut G) -> Bench<'g, G> {
        Bench { gpu, multiprocessors: self.multiprocessors, repeats: self.repeats }
    }

    /// What a reader must know of the times.
    pub fn caveat(&self) -> &'static str {
        if self.real {
            "Times are the device's own (CUDA events)."
        } else {
            "This ran on the CPU in place of a GPU, and smaller: errors count, TIMES ARE THE EMULATOR'S AND MEAN NOTHING."
        }
    }

    /// What a row says of its times.
    pub fn timed_by(&self) -> &'static str {
        if self.real { "CUDA events" } else { "emulator: no speed" }
    }

    /// Billions of vertices a second; of a GPU alone.
    pub fn rate(&self, vertices: usize, ms: f64) -> Option<f64> {
        self.real.then(|| vertices as f64 * 1e-6 / ms)
    }

    /// Heading of a column of times.
    pub fn ms(&self) -> &'static str {
        if self.real { "ms" } else { "emulator ms" }
    }
}
