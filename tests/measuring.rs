//! `compare` and `bench` as a user runs them, on small pictures. What is measured is checked elsewhere; here only that
//! it is written, and that a refusal or an interruption does not end a run.

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
