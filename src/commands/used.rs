//! What a frame really used, for every output that states a measurement.

pub use crate::report::cpu_name;
use crate::stages::{Bound, Engine, Fill, FrameShape, Grid, Options, Precision, Raster, Renderer};
use fearless_simd::Level;
use serde::Serialize;

/// The names are those of the JSON outputs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Used {
    pub backend: &'static str,
    /// What turned triangles into fragments.
    pub raster: &'static str,
    /// The Vulkan device that was given triangles, and its driver.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raster_device: Option<String>,
    /// Pixels from which on quads were that device's, of `hybrid`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub large: Option<f64>,
    pub bound: Bound,
    pub fill: Fill,
    pub grid: Grid,
    /// On a device.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<FrameShape>,
    /// Of evaluation; the CPU has one.
    pub precision: Precision,
    pub device: String,
    pub threads: usize,
}

impl Used {
    /// What a renderer used for its last frame.
    pub fn by(options: &Options, renderer: &Renderer) -> Self {
        let hardware = renderer.rasterizer().filter(|_| options.raster.is_hardware()).map(|r| &r.device().found);
        let raster_device = hardware.map(|found| format!("{} ({})", found.name, found.driver));
        Self { raster_device, large: renderer.threshold(options), ..Self::new(options, renderer.engine()) }
    }

    /// What a frame with these options uses on the current thread pool.
    pub fn new(options: &Options, engine: &Engine) -> Self {
        Self {
            backend: engine.name(),
            raster: match options.raster {
                Raster::Auto | Raster::Software => "software",
                Raster::Hybrid => "hybrid",
                Raster::Hardware => "hardware",
            },
            raster_device: None,
            large: None,
            bound: options.bound,
            fill: options.fill,
            grid: options.grid,
            frame: (!matches!(engine, Engine::Cpu)).then_some(options.shape()),
            precision: if matches!(engine, Engine::Cpu) { Precision::F32 } else { options.precision },
            device: engine.gpu().unwrap_or_else(cpu_name),
            threads: rayon::current_num_threads(),
        }
    }
}

/// The vector instructions that are used here.
pub fn simd_level() -> String {
    let text = format!("{:?}", Level::new());
    text.split(['(', ' ', '{']).next().unwrap_or_default().to_lowercase()
}
