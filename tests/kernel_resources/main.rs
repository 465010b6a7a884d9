//! The machine code of every kernel: there for every target, without spills, and as the committed table says.

mod costs;
#[path = "../support/fresh.rs"]
mod fresh;
mod machine_code;
#[path = "../support/skip.rs"]
mod skip;

use fresh::{agrees, root};
use halfpixel::cuda;
use machine_code::{Dump, Usage, Usages};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;

const TABLE: &str = "bench/results/kernel-resources.md";

/// Kernels with a stack: Bernstein values of any degree beyond 3, what calls save, sums of more than 64 bits. No register is
/// spilled there.
const MAY_STACK: [&str; 25] = [
    "cull_patches",
    "estimate_patches",
    "fill_list",
    "meshlet_drop",
    "meshlet_region",
    "rasterize_bands",
    "rasterize_strokes",
    "settle_find",
    "settle_search",
    "settle_starts",
    "shade_filled",
    "shade_pixels",
    "shade_refuse",
    "shown_pixels",
    "split_patches",
    "stroke_corners",
    "stroke_narrow",
    "stroke_strips",
    "stroke_wide",
    "texture_meshlets",
    "texture_rows",
    "trim_bands",
    "trim_fragments",
    "trim_meshlets",
    "trim_strokes",
];

/// What a multiprocessor has: CUDA C++ Programming Guide, "Technical Specifications per Compute Capability".
struct Multiprocessor {
    warps: u32,
    blocks: u32,
    /// Bytes.
    shared: u32,
}

#[test]
fn kernels_are_there_for_every_target_and_spill_nothing() {
    let Some(dump) = Dump::new("all") else { return };
    let usages = dump.usages();
    assert!(usages.len() >= 8, "{:?}", usages.keys());
    let mut stacks = Vec::new();
    for (kernel, by_target) in &usages {
        let targets: Vec<u32> = by_target.keys().copied().collect();
        assert_eq!(targets, cuda::targets(), "{kernel}");
        let has_one = |u: &Usage| u.local > 0 || u.stack > 0 && !MAY_STACK.contains(&kernel.as_str());
        stacks.extend(by_target.iter().filter(|(_, usage)| has_one(usage)).map(|(target, _)| (kernel, target)));
    }
    assert!(stacks.is_empty(), "these have a stack: {stacks:?}");
    let spills = cuda::toolkit().expect("kernels were built").spills;
    assert!(spills.is_empty() || pinned_version().is_none(), "{spills:#?}");
    let ptx: Vec<String> = usages.keys().cloned().collect();
    assert_eq!(dump.threads().into_keys().collect::<Vec<_>>(), ptx, "PTX has the same kernels, with launch bounds");
}

/// mma.sync m16n8k8 of each kernel on tensor cores: as many as evaluate_mma.cu and evaluate_normals_mma.cu say.
#[test]
fn products_run_on_tensor_cores() {
    let Some(dump) = Dump::new("products") else { return };
    let products = dump.products();
    for (kernel, instruction, count) in [
        ("evaluate_f16", "HMMA.1688.F32", 6),
        ("evaluate_f16_recovered", "HMMA.1688.F32", 14),
        ("evaluate_f16_sparse", "HMMA.SP.16816.F32", 6),
        ("evaluate_normals_f16_sparse", "HMMA.SP.16816.F32", 10),
        ("evaluate_tf32", "HMMA.1688.F32.TF32", 6),
        ("evaluate_tf32_recovered", "HMMA.1688.F32.TF32", 14),
        ("evaluate_normals_f16", "HMMA.1688.F32", 10),
        ("evaluate_normals_f16_recovered", "HMMA.1688.F32", 30),
        ("evaluate_tangents_f16_recovered", "HMMA.1688.F32", 30),
        ("evaluate_normals_tf32", "HMMA.1688.F32.TF32", 10),
        ("evaluate_normals_tf32_recovered", "HMMA.1688.F32.TF32", 30),
    ] {
        let expected = BTreeMap::from([(instruction.to_owned(), count)]);
        for target in cuda::targets() {
            assert_eq!(products.get(&(kernel.to_owned(), *target)), Some(&expected), "{kernel} on sm_{target}");
        }
    }
}

#[test]
fn the_table_of_resources_is_fresh() {
    let Some(dump) = Dump::new("table") else { return };
    let Some(version) = pinned_version() else { return };
    agrees(TABLE, &table(version, &dump.usages(), &dump.threads()));
}

/// The nvcc that made the kernels, if it is the one that committed tables are for.
fn pinned_version() -> Option<&'static str> {
    let version = cuda::toolkit().expect("kernels were built").version;
    let pinned = fs::read_to_string(root().join("scripts/nvcc_wheels.txt")).expect("the list of wheels");
    let same = pinned.contains(&format!("nvidia-cuda-nvcc=={version} "));
    if !same {
        let why = "the table is for the nvcc of scripts/install_nvcc.sh, the kernels were built with";
        skip::skip(format!("{why} {version}"));
    }
    same.then_some(version)
}

#[test]
fn every_kernel_loads_where_there_is_a_device() {
    let missing = cuda::missing();
    if !missing.is_empty() {
        eprintln!("skipped: {}", missing.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "));
        return;
    }
    let fit = |d: &cuda::Device| d.check().is_ok();
    let device = cuda::devices().expect("devices").into_iter().find(fit).expect("one that will do");
    let kernels = cuda::Kernels::load(device.ordinal).expect("kernels load");
    let Some(dump) = Dump::new("load") else { return };
    for name in dump.usages().keys() {
        kernels.get(name).unwrap_or_else(|e| panic!("{e}"));
    }
    assert!(kernels.get("evaluate_f33").is_err());
}

fn table(version: &str, usages: &Usages, threads: &BTreeMap<String, u32>) -> String {
    let mut text = format!(
        "# What kernels take\n\nMade by `HALFPIXEL_UPDATE=1 cargo test --test kernel_resources` from the machine code of nvcc \
         {version}; nothing here was timed. Cells: registers a thread / stack a thread / shared memory a block (bytes; \
         the 1024 that CUDA reserves included) / warps a multiprocessor holds, of those it could.\n\n| kernel | threads \
         a block |"
    );
    let targets = cuda::targets();
    targets.iter().for_each(|t| write!(text, " sm_{t} |").expect("a string"));
    text.push_str("\n|---|---|");
    text.push_str(&"---|".repeat(targets.len()));
    for (kernel, by_target) in usages {
        let threads = threads[kernel];
        write!(text, "\n| {kernel} | {threads} |").expect("a string");
        for (&target, u) in by_target {
            let limits = multiprocessor(target);
            let resident = resident_warps(u, threads, &limits);
            let cell = format!(" {} / {} / {} / {resident} of {} |", u.registers, u.stack, u.shared, limits.warps);
            text.push_str(&cell);
        }
    }
    text.push('\n');
    text
}

fn multiprocessor(target: u32) -> Multiprocessor {
    let (warps, blocks, kib) = match target {
        80 => (64, 32, 164),
        86 => (48, 16, 100),
        89 => (48, 24, 100),
        90 => (64, 32, 228),
        120 => (48, 24, 100),
        other => panic!("enter the limits of sm_{other} here"),
    };
    Multiprocessor { warps, blocks, shared: kib << 10 }
}

/// Warps that registers (64 Ki, given to warps in units of 256), shared memory and the limits above leave.
fn resident_warps(usage: &Usage, threads: u32, limits: &Multiprocessor) -> u32 {
    let warps_a_block = threads.div_ceil(32);
    let registers_a_warp = (usage.registers * 32).next_multiple_of(256);
    let by_registers = 65536 / registers_a_warp / warps_a_block;
    let blocks = by_registers.min(limits.shared / usage.shared).min(limits.blocks).min(limits.warps / warps_a_block);
    blocks * warps_a_block
}
