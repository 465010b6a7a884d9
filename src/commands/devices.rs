//! `halfpixel devices`: lists what frames can be drawn on, and what is missing where one can't.

use super::{backend, output, used};
use crate::{cuda, emulated, vulkan};
use anyhow::{Result, bail};
use serde::Serialize;
use std::{process::ExitCode, thread};

/// List what frames can be drawn on
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Load every kernel on every CUDA device; fails where one does not load, or where there is no device
    #[arg(long)]
    pub load: bool,
}

#[derive(Serialize)]
struct Devices {
    devices: Vec<Device>,
    /// What can't be used, why, and what to do.
    missing: Vec<Missing>,
    /// What compiled the kernels of this program.
    nvcc: Option<&'static str>,
    /// Kernels that were loaded on each CUDA device, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    loaded: Option<usize>,
}

#[derive(Serialize)]
#[serde(tag = "backend", rename_all = "lowercase")]
enum Device {
    Cpu {
        name: String,
        /// Hardware threads this process may use.
        threads: usize,
        simd: String,
    },
    Cuda(cuda::Device),
    Vulkan(vulkan::Found),
}

#[derive(Serialize)]
struct Missing {
    backend: &'static str,
    reasons: Vec<String>,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let threads = thread::available_parallelism().map_or(1, Into::into);
    let mut devices = vec![Device::Cpu { name: used::cpu_name(), threads, simd: used::simd_level() }];
    let (of_cuda, of_vulkan) = (cuda::devices().unwrap_or_default(), vulkan::devices().unwrap_or_default());
    let uuids = of_cuda.iter().map(|d| (d.name.as_str(), d.vulkan_uuid()));
    let alone = alone(uuids, &of_vulkan);
    devices.extend(of_cuda.into_iter().map(Device::Cuda));
    devices.extend(of_vulkan.into_iter().map(Device::Vulkan));
    let missing = [
        ("cuda", backend::cuda_missing()),
        ("emulated", backend::emulated_missing()),
        ("vulkan", backend::vulkan_missing()),
        ("vulkan", alone),
    ];
    let missing = missing.into_iter().filter(|(_, reasons)| !reasons.is_empty());
    let missing = missing.map(|(backend, reasons)| Missing { backend, reasons }).collect();
    let loaded = if args.load { Some(load()?) } else { None };
    let devices = Devices { devices, missing, nvcc: cuda::toolkit().map(|t| t.version), loaded };
    if args.json {
        output::print_json(&devices)?;
        return Ok(ExitCode::SUCCESS);
    }
    for device in &devices.devices {
        output::print(&line(device))?;
    }
    for m in &devices.missing {
        for reason in &m.reasons {
            output::print(&format!("{:<9}not available: {reason}", m.backend))?;
        }
    }
    if let Some(count) = devices.loaded {
        output::print(&format!("{count} kernels load"))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// CUDA's devices, by name and UUID, that Vulkan can't draw with.
fn alone<'a>(of_cuda: impl Iterator<Item = (&'a str, &'a str)>, of_vulkan: &[vulkan::Found]) -> Vec<String> {
    let draws = |uuid: &str| of_vulkan.iter().any(|d| d.uuid == uuid && d.missing.is_empty());
    let so = "with --backend cuda, --raster hybrid and hardware use another device, and copy";
    of_cuda.filter(|(_, uuid)| !draws(uuid)).map(|(name, _)| format!("{name} draws no meshlets: {so}")).collect()
}

/// Looks up all kernels on all devices; the emulated ones have the same names.
fn load() -> Result<usize> {
    let names = emulated::kernels();
    if names.is_empty() {
        bail!("the names of the kernels are not known here: {}", backend::emulated_missing().join("; "));
    }
    for device in cuda::devices()? {
        let kernels = cuda::Kernels::load(device.ordinal)?;
        names.iter().try_for_each(|name| kernels.get(name).map(|_| ()))?;
    }
    Ok(names.len())
}

fn line(device: &Device) -> String {
    match device {
        Device::Cpu { name, threads, simd } => format!("{:<9}{name} ({threads} threads, {simd})", "cpu"),
        Device::Cuda(d) => {
            let ([major, minor], [cuda, cuda_minor]) = (d.compute_capability, d.driver.cuda);
            let driver = d.driver.version.as_deref().unwrap_or("unknown");
            let gib = d.memory as f64 / f64::from(1 << 30);
            format!(
                "{:<9}{} (device {}, compute capability {major}.{minor}, {} multiprocessors, {gib:.1} GiB, driver \
                 {driver} for CUDA {cuda}.{cuda_minor}, {})",
                "cuda", d.name, d.ordinal, d.multiprocessors, d.uuid
            )
        }
        Device::Vulkan(d) => {
            let able = match (d.missing.is_empty(), d.absent.is_empty()) {
                (false, _) => format!("; lacks {}", d.missing.join(", ")),
                (true, false) => format!("; {}", d.absent.join("; ")),
                (true, true) => String::new(),
            };
            format!("{:<9}{} ({}, {}, {}{able})", "vulkan", d.name, d.kind, d.driver, d.uuid)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_only_cuda_can_use_is_named() {
        let found = |uuid: &str, missing: &[&str]| vulkan::Found {
            name: "a GPU".into(),
            driver: "a driver".into(),
            uuid: uuid.into(),
            kind: "discrete",
            missing: missing.iter().map(|&m| m.into()).collect(),
            absent: Vec::new(),
        };
        let of_vulkan = [found("1", &[]), found("2", &["meshShader"])];
        let said = alone([("one", "1"), ("two", "2"), ("three", "3")].into_iter(), &of_vulkan);
        assert_eq!(said.len(), 2);
        assert!(said[0].starts_with("two ") && said[1].starts_with("three "), "{said:?}");
    }
}
