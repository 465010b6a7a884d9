//! Every pair of model, bound, precision, shape of a frame and view on the emulated GPU, as `bench matrix` judges it: f32 has
//! the CPU's words, anything else keeps the contract and its bounds. bench/matrix.sh has all combinations.

use std::path::{Path, PathBuf};
use std::process::Command;

const BUILT_IN: [&str; 7] = ["teapot", "sphere", "torus", "drum", "stress", "trimmed:drilled", "trimmed:degree22"];
const REAL: [&str; 3] = ["killeroo.bpt", "screw.step", "so100_Wrist_Roll_08c.step"];

/// Real files, where there are any.
fn real() -> Vec<String> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let folder = std::env::var_os("HALFPIXEL_MODELS").map_or(beside, PathBuf::from);
    let there = |name: &&'static str| {
        let is_there = folder.join(name).is_file();
        if !is_there {
            eprintln!("skipped: there is no {} (set HALFPIXEL_MODELS)", folder.join(name).display());
        }
        is_there
    };
    REAL.into_iter().filter(there).map(|name| folder.join(name).display().to_string()).collect()
}

#[test]
fn pairs_of_all_choices_keep_the_contract() {
    let mut program = Command::new(env!("CARGO_BIN_EXE_halfpixel"));
    program.args(["bench", "matrix", "--pairwise", "--backend", "emulated", "--size", "160x120"]);
    program.args(BUILT_IN.map(|name| format!("builtin:{name}"))).args(real());
    let out = program.output().expect("the program runs");
    let (found, said) = (String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
    assert!(out.status.success(), "{found}\n{said}");
    // Every precision was drawn in both shapes.
    let rows = found.lines().filter(|line| line.contains("| fused ") || line.contains("| staged "));
    let drawn = |row: &str| row.split('|').nth(5).and_then(|hold| hold.trim().parse::<u32>().ok());
    assert_eq!(rows.filter(|row| drawn(row).is_some_and(|n| n > 0)).count(), 14, "{found}");
}
