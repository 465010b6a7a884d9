//! What several tests need.
#![allow(dead_code)] // each test file uses its own part

pub mod heap;
pub mod random;

use std::path::PathBuf;

/// A real model that is no part of this project, in $HALFPIXEL_MODELS or ../shared/models; says so where it is missing.
pub fn real_model(name: &str) -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let folder = std::env::var_os("HALFPIXEL_MODELS").map_or(beside, PathBuf::from);
    let path = folder.join(name);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("skipped: there is no {} (set HALFPIXEL_MODELS)", path.display());
    None
}

/// A `.bpt` file of bicubic patches with smooth nonsense for coordinates.
pub fn bpt_text(patches: usize) -> String {
    let mut text = format!("{patches}\n");
    for k in 0..patches {
        text += "3 3\n";
        for i in 0..16 {
            let t = (16 * k + i) as f64;
            text += &format!("{:.6} {:.6} {:.6}\n", (t * 0.7).sin(), (t * 1.3).cos(), t * 0.01);
        }
    }
    text
}

/// `count` lines of `width` numbers.
pub fn numbers(count: usize, width: usize) -> String {
    let line = |i: usize| (0..width).map(|k| format!("{}", (i * width + k) as f64 * 0.25 + 1.0)).collect::<Vec<_>>();
    (0..count).map(|i| line(i).join(" ") + "\n").collect()
}

/// A `.bv` file with one segment of every kind, and groups.
pub fn bv_text() -> String {
    let polyhedron = "1\n4 2\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    format!(
        "group 0 body\n4\n2\n{}group 1 the lid\n5\n1 2\n{}8\n1 1\n{}{polyhedron}Group 2\n3\n2\n{}9\n1 1\n{}10\n1 1 1 1\n{}",
        numbers(9, 3),
        numbers(6, 3),
        numbers(4, 4),
        numbers(6, 3),
        numbers(6, 3),
        numbers(8, 3),
    )
}
