//! The shape of the sources: files and functions that stay short, and a file for every stage of the frame.

use std::path::{Path, PathBuf};
use std::{fs, io};

const FILE_LINES: usize = 450;
const FUNCTION_LINES: usize = 80;
/// Stages of the frame: each has a file in src/stages and its twins in src/cuda and in kernels.
const STAGES: [&str; 7] = ["cull", "estimate", "evaluate", "rasterize", "trim", "fill", "shade"];
/// Made by programs.
const GENERATED: [&str; 2] = ["src/cuda/abi.rs", "vk_shaders/abi.glsl"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn files_stay_short() {
    let kernels = files_in("kernels", &["cu", "cuh", "h", "cpp"]);
    let shaders = files_in("vk_shaders", &["mesh", "task", "frag", "vert", "tesc", "tese", "comp", "geom", "glsl"]);
    let long = sources().into_iter().chain(kernels).chain(shaders).filter_map(|path| {
        let lines = read(&path).lines().count();
        let long = lines > FILE_LINES && !GENERATED.contains(&shown(&path).as_str());
        long.then(|| format!("{}: {lines} lines", shown(&path)))
    });
    let long: Vec<String> = long.collect();
    assert!(long.is_empty(), "files above {FILE_LINES} lines:\n{}", long.join("\n"));
}

#[test]
fn functions_stay_short() {
    let mut long = Vec::new();
    for path in sources() {
        for (name, first, lines) in functions(&read(&path)) {
            if lines > FUNCTION_LINES {
                long.push(format!("{}:{first}: {name} has {lines} lines", shown(&path)));
            }
        }
    }
    assert!(long.is_empty(), "functions above {FUNCTION_LINES} lines:\n{}", long.join("\n"));
}

#[test]
fn every_stage_has_its_file() {
    let has = |stem: &str, folder: &str, suffix: &str| {
        let folder = root().join(folder);
        folder.join(format!("{stem}.{suffix}")).is_file() || folder.join(stem).join("mod.rs").is_file()
    };
    let places = [("src/stages", "rs"), ("src/cuda", "rs"), ("kernels", "cu")];
    let all = STAGES.into_iter().flat_map(|stem| places.map(|(folder, suffix)| (stem, folder, suffix)));
    let missing: Vec<_> = all.filter(|&(stem, folder, suffix)| !has(stem, folder, suffix)).collect();
    assert!(missing.is_empty(), "stages without a file: {missing:?}");
}

#[test]
fn function_lengths_are_seen() {
    let text = "impl A {\n    pub(crate) const fn one() {}\n\n    fn two<T>(\n        x: T,\n    ) {\n        if x {\n        }\n    }\n}\n\
                \nfn three();\n\nasync fn four() {\n    fn_like();\n}\n";
    let found: Vec<_> = functions(text).into_iter().collect();
    assert_eq!(found, [("one".into(), 2, 1), ("two".into(), 4, 6), ("three".into(), 12, 1), ("four".into(), 14, 3)]);
}

/// Name, first line and number of lines of every function. Relies on rustfmt: a body ends at a closing brace that is
/// indented like the line with `fn`.
fn functions(text: &str) -> Vec<(String, usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let Some(name) = function_name(line) else { continue };
        let indent = &line[..line.len() - line.trim_start().len()];
        let ends_here = line.ends_with(['}', ';']);
        let closing = format!("{indent}}}");
        // A declaration over several lines ends with `;` at the same indentation.
        let semicolon = |l: &str| l.starts_with(&format!("{indent})")) && l.ends_with(';');
        let after = lines[i + 1..].iter().position(|l| **l == closing || semicolon(l));
        let length = if ends_here { 1 } else { after.map_or(1, |n| n + 2) };
        found.push((name.to_owned(), i + 1, length));
    }
    found
}

fn function_name(line: &str) -> Option<&str> {
    let mut rest = line.trim_start();
    if let Some(after) = rest.strip_prefix("pub(") {
        rest = after.split_once(") ")?.1;
    }
    while let Some(after) = ["pub ", "const ", "async ", "unsafe "].iter().find_map(|word| rest.strip_prefix(word)) {
        rest = after;
    }
    let name = rest.strip_prefix("fn ")?;
    Some(name.split(['(', '<']).next().unwrap_or(name))
}

/// All Rust files of the project, sorted.
fn sources() -> Vec<PathBuf> {
    ["src", "tests"].into_iter().flat_map(|folder| files_in(folder, &["rs"])).collect()
}

/// Files of a folder that end so, sorted.
fn files_in(folder: &str, suffixes: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    collect(&root().join(folder), suffixes, &mut files).unwrap_or_else(|e| panic!("cannot list {folder}: {e}"));
    files.sort();
    assert!(!files.is_empty());
    files
}

fn collect(folder: &Path, suffixes: &[&str], files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, suffixes, files)?;
        } else if path.extension().is_some_and(|e| suffixes.iter().any(|s| e == *s)) {
            files.push(path);
        }
    }
    Ok(())
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("cannot read {}: {e}", path.display()))
}

fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}
