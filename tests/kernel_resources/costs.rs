//! What evaluating a meshlet costs by the machine code: a model of pipes, not a measurement.

use crate::fresh::agrees;
use crate::machine_code::{Dump, Instruction};
use crate::pinned_version;
use halfpixel::cuda;
use std::collections::BTreeMap;
use std::fmt::Write;

const TABLE: &str = "bench/results/evaluate-costs.md";
const SOURCE: &str = "src/cuda/clocks.rs";
const ALL: &str = "bench/results/kernel-costs.md";
const PIPES: [&str; 7] = ["issue", "FMA", "integer", "tensor", "memory", "special", "f64"];

/// Clocks that instructions of a warp keep the pipes of a multiprocessor busy; sources and confidence: research
/// "kernel-study", "Rates". sm_80: A100 whitepaper, 64 FP32 lanes, 1024 f16 FMA a clock; sm_89 as sm_86.
struct Rates {
    fma: f64,
    integer: f64,
    /// FMA and integer instructions share issue ports: clocks for either.
    shared: f64,
    /// HMMA.1688 of f16 summed in f32; tf32 takes twice that.
    product: f64,
    /// 32 lanes of f64 on sm_80, 64 on sm_90, two elsewhere.
    double: f64,
}

fn rates(target: u32) -> Rates {
    match target {
        80 => Rates { fma: 0.5, integer: 0.5, shared: 0.0, product: 1.0, double: 1.0 },
        86 | 89 => Rates { fma: 0.25, integer: 0.5, shared: 0.25, product: 4.0, double: 16.0 },
        90 => Rates { fma: 0.25, integer: 0.5, shared: 0.0, product: 0.8, double: 0.5 },
        120 => Rates { fma: 0.25, integer: 0.25, shared: 0.25, product: 4.0, double: 16.0 },
        other => panic!("enter the rates of sm_{other} here"),
    }
}

/// A warp's meshlet on one target.
struct Cost {
    instructions: usize,
    /// By `PIPES`.
    clocks: [f64; 7],
    /// Of global memory, all lanes together.
    bytes: usize,
}

impl Cost {
    fn of(way: &[&Instruction], rates: &Rates) -> Self {
        let mut clocks = [0.0; 7];
        let (mut arithmetic, mut bytes) = (0.0, 0);
        for i in way {
            clocks[0] += 0.25;
            let name = i.operation.split('.').next().unwrap_or_default();
            if matches!(name, "LDG" | "STG" | "ATOMG" | "RED") {
                bytes += 128 * wavefronts(&i.operation) as usize;
            }
            match name {
                "DADD" | "DMUL" | "DFMA" | "DSETP" => clocks[6] += rates.double,
                "FFMA" | "FADD" | "FMUL" | "HFMA2" | "HADD2" | "HMUL2" | "IMAD" => {
                    clocks[1] += rates.fma;
                    arithmetic += 1.0;
                }
                "HMMA" => clocks[3] += rates.product * if i.operation.contains("TF32") { 2.0 } else { 1.0 },
                "LDG" | "LDS" | "STG" | "STS" | "LDL" | "STL" | "ATOMG" | "ATOMS" | "RED" | "REDUX" | "SHFL" => {
                    clocks[4] += wavefronts(&i.operation)
                }
                "MUFU" | "F2I" | "I2F" => clocks[5] += 2.0,
                "BRA" | "BSSY" | "BSYNC" | "EXIT" | "NOP" | "WARPSYNC" | "LDC" | "LDCU" | "S2R" | "S2UR" => {}
                // Uniform instructions have a pipe of their own.
                _ if name.starts_with('U') => {}
                _ => {
                    clocks[2] += rates.integer;
                    arithmetic += 1.0;
                }
            }
        }
        clocks[1] = clocks[1].max(rates.shared * arithmetic);
        Self { instructions: way.len(), clocks, bytes }
    }

    /// The busiest pipe.
    fn bound(&self) -> (f64, &'static str) {
        let pipes = self.clocks.into_iter().zip(PIPES);
        pipes.max_by(|a, b| a.0.total_cmp(&b.0)).expect("a pipe")
    }
}

fn wavefronts(operation: &str) -> f64 {
    if operation.contains(".128") {
        4.0
    } else if operation.contains(".64") {
        2.0
    } else {
        1.0
    }
}

/// The longest way through a kernel that calls nothing (division's slow path). `None` where it has loops, unless they are
/// taken once: threads that persist.
fn longest_way(code: &[Instruction], once: bool) -> Option<Vec<&Instruction>> {
    const NEVER: i64 = -1_000_000;
    let index: BTreeMap<u64, usize> = code.iter().enumerate().map(|(k, i)| (i.address, k)).collect();
    // Instructions from here to the end, and the next one on the way.
    let mut ways: Vec<(i64, Option<usize>)> = vec![(0, None); code.len() + 1];
    for (k, i) in code.iter().enumerate().rev() {
        let ends = !i.conditional && ["EXIT", "RET"].iter().any(|name| i.operation.starts_with(name));
        let target = i.target().map(|address| index[&address]);
        let mut next: Vec<usize> = Vec::new();
        next.extend(target.filter(|&t| t > k));
        next.extend((!ends && (i.conditional || target.is_none())).then_some(k + 1));
        let best = next.into_iter().max_by_key(|&n| ways[n].0);
        let own = if i.operation.starts_with("CALL") || i.operation.starts_with("RET") { NEVER } else { 1 };
        ways[k] = (own + best.map_or(0, |n| ways[n].0), best);
        if !once && target.is_some_and(|t| t < k) {
            return None;
        }
    }
    let mut way = Vec::new();
    let mut at = Some(0);
    while let Some(k) = at.filter(|&k| k < code.len()) {
        way.push(&code[k]);
        at = ways[k].1;
    }
    Some(way)
}

#[test]
fn the_table_of_costs_is_fresh() {
    let Some(dump) = Dump::new("costs") else { return };
    let Some(version) = pinned_version() else { return };
    let mut costs: BTreeMap<String, BTreeMap<u32, Cost>> = BTreeMap::new();
    for ((kernel, target), code) in dump.instructions() {
        let persistent = kernel.starts_with("evaluate_eter_d");
        if let Some(way) = longest_way(&code, persistent).filter(|_| kernel.starts_with("evaluate_")) {
            costs.entry(kernel).or_default().insert(target, Cost::of(&way, &rates(target)));
        }
    }
    agrees(TABLE, &table(version, &costs));
    agrees(SOURCE, &source(&costs));
}

/// Every kernel: the longest way through it or, where it loops or calls, all of its code once.
#[test]
fn the_table_of_all_kernels_is_fresh() {
    let Some(dump) = Dump::new("all-costs") else { return };
    let Some(version) = pinned_version() else { return };
    let mut cells: BTreeMap<String, BTreeMap<u32, String>> = BTreeMap::new();
    for ((kernel, target), code) in dump.instructions() {
        let calls = |way: &Vec<&Instruction>| way.iter().any(|i| i.operation.starts_with("CALL"));
        let straight = longest_way(&code, false).filter(|way| !calls(way));
        let mark = if straight.is_some() { "" } else { "~" };
        // Padding behind the end is no instruction.
        let all = || code.iter().filter(|i| i.operation != "NOP").collect();
        let cost = Cost::of(&straight.unwrap_or_else(all), &rates(target));
        let (clocks, pipe) = cost.bound();
        let cell = format!("{mark}{}, {clocks:.1} {pipe}, {}", cost.instructions, cost.bytes);
        cells.entry(kernel).or_default().insert(target, cell);
    }
    let mut text = format!(
        "# What every kernel's machine code costs, computed and not measured\n\nMade by `HALFPIXEL_UPDATE=1 cargo test --test \
         kernel_resources` from the machine code of nvcc {version}. Cells: instructions of a warp, what its busiest pipe takes \
         for them in clocks of a multiprocessor (rates: tests/kernel_resources/costs.rs), and bytes of global memory that the \
         warp loads and stores. `~`: the kernel has loops or calls, and every instruction of it is counted once; what that \
         comes to depends on the data. Without it: the longest way through. f64 is a 64th of f32 on sm_86, sm_89 and sm_120.\n\n\
         | kernel |"
    );
    let targets = cuda::targets();
    targets.iter().for_each(|t| write!(text, " sm_{t} |").expect("a string"));
    text.push_str("\n|---|");
    text.push_str(&"---|".repeat(targets.len()));
    for (kernel, by_target) in cells {
        write!(text, "\n| {kernel} |").expect("a string");
        by_target.values().for_each(|cell| write!(text, " {cell} |").expect("a string"));
    }
    text.push('\n');
    agrees(ALL, &text);
}

fn table(version: &str, costs: &BTreeMap<String, BTreeMap<u32, Cost>>) -> String {
    let mut text = format!(
        "# What evaluating a meshlet costs, computed and not measured\n\nMade by `HALFPIXEL_UPDATE=1 cargo test --test \
         kernel_resources` from the machine code of nvcc {version}. Cells: instructions of a warp on the longest way that \
         takes no slow division, and what its busiest pipe takes for them, in clocks of a multiprocessor; rates: \
         tests/kernel_resources/costs.rs. A meshlet of 8 x 8 vertices stores 1024 bytes, with normals 1536, with tangents \
         3072. evaluate_eter has two warps a meshlet: its cells are for one. Other kernels with loops are not here.\n\n\
         | kernel |"
    );
    let targets = cuda::targets();
    targets.iter().for_each(|t| write!(text, " sm_{t} |").expect("a string"));
    text.push_str("\n|---|");
    text.push_str(&"---|".repeat(targets.len()));
    for (kernel, by_target) in costs {
        write!(text, "\n| {kernel} |").expect("a string");
        for target in targets {
            let cell = by_target.get(target).map_or_else(
                || " loops |".into(),
                |cost| {
                    let (clocks, pipe) = cost.bound();
                    format!(" {}, {clocks:.1} {pipe} |", cost.instructions)
                },
            );
            text.push_str(&cell);
        }
    }
    text.push('\n');
    text
}

/// The table that `--precision auto` goes by.
fn source(costs: &BTreeMap<String, BTreeMap<u32, Cost>>) -> String {
    let mut text = format!(
        "//! Clocks of a multiprocessor that evaluating a meshlet takes, by arithmetic and device: computed from the machine code, not\n\
         //! measured. `HALFPIXEL_UPDATE=1 cargo test --test kernel_resources` writes this, with {TABLE}.\n\n\
         use super::selection::Clocks;\n\npub(super) const CLOCKS: [Clocks; {}] = [\n",
        cuda::targets().len()
    );
    for target in cuda::targets() {
        let clocks = |kernel: &str| format!("{:.1}", costs[kernel][target].bound().0);
        let f32: Vec<String> = (1..=7).map(|degree| clocks(&format!("evaluate_f32_d{degree}"))).collect();
        let tensor = ["f16", "f16_recovered", "tf32", "tf32_recovered"]
            .map(|name| format!("{name}: {}", clocks(&format!("evaluate_{name}"))));
        writeln!(text, "    Clocks {{ target: {target}, f32: [{}], {} }},", f32.join(", "), tensor.join(", "))
            .expect("a string");
    }
    text.push_str("];\n");
    text
}
