//! `compare` and `bench` as a user runs them, on small pictures. What is measured is checked elsewhere; here only that
//! it is written, and that a refusal or an interruption does not end a run.

#[path = "support/skip.rs"]
mod skip;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const SMALL: [&str; 4] = ["--size", "64x48", "--samples", "20"];

/// A folder that goes away with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("halfpixel-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn prefix(&self) -> String {
        self.0.join("out").display().to_string()
    }

    fn read(&self, name: &str) -> String {
        read(&self.0.join(name))
    }

    fn json(&self) -> Value {
        serde_json::from_str(&self.read("out.json")).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Runs the program; it must succeed.
fn halfpixel(arguments: &[&str]) -> Output {
    let out = Command::new(env!("CARGO_BIN_EXE_halfpixel")).args(arguments).output().unwrap();
    assert!(out.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&out.stderr));
    out
}

fn count(value: &Value) -> usize {
    value.as_array().map_or(0, Vec::len)
}

#[test]
fn compare_writes_tables_and_plots() {
    let folder = Folder::new("compare");
    let mut line = vec!["compare", "builtin:sphere", "--views", "iso", "--zooms", "1", "--tolerances", "0.5"];
    let prefix = folder.prefix();
    line.extend(["--frames", "1", "-o", &prefix, "--json"]);
    line.extend(SMALL);
    let out = halfpixel(&line);
    let said: Value = serde_json::from_slice(&out.stdout).unwrap();
    // Five bounds on two grids; slefe has nothing to say about a rational sphere.
    assert_eq!((count(&said["rows"]), count(&said["points"])), (10, 8));
    assert_eq!(count(&folder.json()), 10);
    assert_eq!(folder.read("out.csv").lines().count(), 11);
    assert!(folder.read("out.md").contains("refused: "));
    assert!(folder.read("out.svg").contains("the contract"));
    assert!(folder.0.join("out.png").exists());
}

#[test]
fn an_interrupted_contract_run_goes_on() {
    let folder = Folder::new("contract");
    let prefix = folder.prefix();
    let run = |views: &str, more: &[&str]| {
        let mut line = vec!["bench", "contract", "builtin:torus", "--zooms", "1", "--projections", "orthographic"];
        line.extend(["--bounds", "screen,slefe", "--frames", "1", "--views", views, "-o", &prefix]);
        line.extend(SMALL);
        line.extend(more);
        halfpixel(&line);
        folder.json()
    };
    let first = run("iso", &[]);
    let second = run("iso,top", &["--resume"]);
    assert_eq!((count(&first["rows"]), count(&second["rows"])), (2, 4));
    // Times differ from run to run: the same ones mean that the row was kept.
    assert_eq!(first["rows"][0], second["rows"][0]);
    assert_eq!(second["tables"]["By model and bound"][0]["violations"], 0);
}

#[test]
fn the_other_suites_run() {
    let folder = Folder::new("suites");
    let prefix = folder.prefix();
    let sphere = ["builtin:sphere", "--size", "64x48"];
    halfpixel(&[&["bench", "quads"], &sphere[..], &["--views", "iso", "--zooms", "1", "-o", &prefix]].concat());
    assert_eq!(count(&folder.json()["rows"]), 22);
    halfpixel(&[&["bench", "speed"], &sphere[..], &["--frames", "2", "-o", &prefix]].concat());
    assert!(folder.read("out.md").contains("geometry (estimate to fill)"));
    let cases =
        ["bench", "stability", "--only", "twist,1/100", "--samples", "20", "-o", &prefix, "--", "--size", "64x48"];
    halfpixel(&cases);
    let cases = &folder.json()["tables"]["Cases"];
    assert_eq!(count(cases), 4);
    assert!(cases.as_array().unwrap().iter().all(|case| case["not finite"] == 0));
}

/// Runs a suite of kernels on the CPU; `None` where this build can't.
fn kernels(folder: &Folder, line: &[&str]) -> Option<Value> {
    if let Some(why) = halfpixel::emulated::missing() {
        skip::skip(why);
        return None;
    }
    halfpixel(&[line, &["--backend", "emulated", "-o", &folder.prefix()]].concat());
    Some(folder.json())
}

#[test]
fn every_kernel_of_evaluate_has_a_time_and_an_error() {
    let folder = Folder::new("evaluate");
    let line = ["bench", "evaluate", "--patches", "2", "--degrees", "3", "--forget"];
    let Some(found) = kernels(&folder, &line) else { return };
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 15);
    assert_eq!(folder.read("out.csv").lines().count(), 16);
    for row in rows {
        let allowed = match row["arithmetic"].as_str().unwrap() {
            "f16" | "f16_sparse" | "tf32" => 2e-3,
            _ => 1e-6,
        };
        assert!(row["error_max_of_extent"].as_f64().unwrap() < allowed, "{row}");
        assert!(row["store_floor_ms"].as_f64().unwrap() > 0.0 && row["arithmetic_floor_ms"].as_f64().unwrap() > 0.0);
        assert_eq!((row["timed_by"].as_str(), row["vertices"].as_u64()), (Some("emulator: no speed"), Some(8192)));
    }
    assert!(folder.read("out.md").contains("MEAN NOTHING"));
    let verdicts = &found["tables"]["What a GPU must reach"];
    assert_eq!((count(verdicts), &verdicts[0]["verdict"]), (1, &Value::from("pending")));
}

#[test]
fn no_arithmetic_leaves_its_bound() {
    let folder = Folder::new("precision");
    let Some(found) = kernels(&folder, &["bench", "precision", "--patches", "1"]) else { return };
    let rows = found["rows"].as_array().unwrap();
    // Degrees 1 to 7 and eight more cases in six arithmetics, degree 22 in one; one more that is not centred.
    assert_eq!(rows.len(), 6 * 16 + 1);
    let centred = rows.iter().filter(|row| row["centred"] == 1);
    centred.for_each(|row| assert!(row["largest_part_of_bound"].as_f64().unwrap() <= 1.0, "{row}"));
}

#[test]
fn frames_of_copies_are_measured_and_fitted() {
    let folder = Folder::new("frame");
    let prefix = folder.prefix();
    let line = ["bench", "frame", "builtin:torus", "--patches", "70", "--frames", "1", "-o", &prefix];
    halfpixel(&[&line[..], &SMALL].concat());
    let found = folder.json();
    // Of one with and without trims, of more as they are; ours and ETER's. Two more of each for the fit.
    let copies = count(&found["tables"]["Breakdown at 64x48"]) / 2 - 1;
    assert!((2..=4).contains(&copies), "{copies}");
    assert_eq!(count(&found["rows"]), 4 + 2 * (copies - 1) + 4 * copies);
    let text = folder.read("out.md");
    assert!(text.contains("ns a triangle") && text.contains("Measured with --backend cpu on "), "{text}");
    let verdicts = found["tables"]["What a GPU must reach"].as_array().unwrap();
    assert!(verdicts.len() == 4 && verdicts.iter().all(|v| v["verdict"] == "pending"), "{verdicts:?}");
}

#[test]
fn kernels_draw_what_the_cpu_draws() {
    let folder = Folder::new("backends");
    let line = ["bench", "backends", "builtin:trimmed:plate", "builtin:torus", "--size", "48x32"];
    let Some(found) = kernels(&folder, &line) else { return };
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    assert!(rows.iter().all(|row| row["words"] == 0 && row["drawn"].as_u64() > Some(0)), "{rows:?}");
}
