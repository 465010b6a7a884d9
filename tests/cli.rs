//! The program as a user meets it: exit status, one-line errors, JSON alone on standard output.

mod support;

use clap::Parser;
use glam::{DVec2, Vec3};
use halfpixel::commands::Cli;
use halfpixel::commands::attributes::{NO_ID, attributes};
use halfpixel::import;
use halfpixel::scene::{ViewSpec, prepare};
use halfpixel::stages::{Options, Renderer};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use support::{bpt_text, bv_text};

fn halfpixel(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfpixel"));
    command.args(arguments).stdin(Stdio::null()).output().expect("the program starts")
}

/// Standard error's only line, after the program's name.
fn error_line(arguments: &[&str], status: i32) -> String {
    let output = halfpixel(arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {text}");
    assert!(output.stdout.is_empty(), "{arguments:?}: {:?}", String::from_utf8_lossy(&output.stdout));
    assert_eq!(text.lines().count(), 1, "{arguments:?}: {text}");
    text.trim_end().strip_prefix("halfpixel: ").expect("opens with the program's name").to_owned()
}

/// Standard output as one JSON object; the status must be 0.
fn json(arguments: &[&str]) -> Value {
    let output = halfpixel(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&output.stdout).expect("one JSON value and nothing else");
    assert!(value.is_object());
    value
}

/// A folder of this test's own, removed when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("halfpixel-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }

    fn file(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.join(name), text).expect("a temporary file");
        self.path(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn help_and_version_are_no_errors() {
    for arguments in [&["--help"][..], &["--version"], &["render", "--help"], &["verify", "-h"], &["compare", "-h"]] {
        let output = halfpixel(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(!output.stdout.is_empty() && output.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn wrong_usage_is_one_line_and_status_2() {
    for arguments in [
        &[][..],
        &["paint"],
        &["info"],
        &["info", "--nonsense", "x"],
        &["render", "builtin:teapot"],
        &["render", "builtin:teapot", "-o", "picture.jpg"],
        &["render", "builtin:teapot", "-o", "picture"],
        &["info", "builtin:nothing"],
        &["render", "builtin:teapot", "-o", "a.png", "--size", "-1x5"],
        &["render", "builtin:teapot", "-o", "a.png", "--bound", "best"],
        &["bench", "evaluate", "--backend", "cpu"],
        &["bench", "backends", "builtin:teapot", "--backend", "cpu"],
    ] {
        error_line(arguments, 2);
    }
    assert!(error_line(&["render", "m", "-o", "a.png", "--toleranc", "1"], 2).contains("--tolerance"), "a hint");
    assert!(error_line(&["info", "builtin:nothing"], 2).contains("teapot"), "what there is");
}

#[test]
fn values_out_of_range_are_wrong_usage() {
    for (option, values) in [
        ("--size", &["0x10", "10x0", "10", "10x", "x", "99999x10", "-1x5", "16384x16384", "1e3x5"][..]),
        ("--tolerance", &["0", "-1", "10.5", "nan", "inf", "half", ""]),
        ("--depth-tolerance", &["0", "-1", "nan", "inf"]),
        ("--fov", &["0", "180", "-45", "nan"]),
        ("--zoom", &["0", "-1", "inf", "nan"]),
        ("--refine", &["-1", "17", "1.5"]),
        ("--threads", &["0", "-1", "100000"]),
        ("--eye", &["1,2", "1,2,3,4", "a,b,c", "nan,0,0", "1e999,0,0", "1e300,0,0"]),
        ("--up", &["0,0,0"]),
        ("--bound", &["best", "Screen "]),
        ("--view", &["side"]),
        ("--up-axis", &["x"]),
        ("--show", &["all"]),
    ] {
        for value in values {
            // Parsed here: that the program makes one line and status 2 of it is tested above.
            let arguments = ["halfpixel", "render", "builtin:teapot", "-o", "a.png", option, value];
            let message = Cli::try_parse_from(arguments).expect_err(value).to_string();
            assert!(message.contains(option), "{option} {value}: {message}");
        }
    }
    let same = ["render", "builtin:teapot", "-o", "a.png", "--eye", "1,2,3", "--target", "1,2,3"];
    assert!(error_line(&same, 2).contains("same point"));
    error_line(&["compare", "builtin:teapot", "--tolerances", "0.5,0"], 2);
    error_line(&["compare", "builtin:teapot", "--bounds", "screen,best"], 2);
}

#[test]
fn failures_are_one_line_and_status_1() {
    let folder = Folder::new("failures");
    let empty = folder.file("empty.bpt", "");
    let brep = folder.file("part.bpt", "DBRep_DrawableShape\n");
    let broken = folder.file("broken.bpt", &bpt_text(2).replacen("0.010000", "0.0l0000", 1));
    assert!(error_line(&["info", "/nowhere/a.bpt"], 1).starts_with("/nowhere/a.bpt: "));
    assert!(error_line(&["info", &folder.path("")], 1).contains("directory"));
    assert!(error_line(&["info", &empty], 1).contains("empty"));
    assert!(error_line(&["info", &brep], 1).contains("BREP files are not read yet"));
    assert!(error_line(&["info", &broken], 1).contains("line 4: expected a finite number, found \"0.0l0000\""));
    assert!(error_line(&["info", "a\nb"], 1).starts_with("a b: "), "names are kept on one line");
    let picture = folder.path("none/picture.png");
    assert!(error_line(&["render", "builtin:teapot", "-o", &picture], 1).contains("there is no folder"));
}

#[test]
fn info_tells_the_teapot() {
    let info = json(&["info", "builtin:teapot", "--json"]);
    for (key, value) in [("faces", 32), ("unique_faces", 32), ("surfaces", 32), ("bezier_patches", 32), ("trims", 0)] {
        assert_eq!(info[key], value, "{key}");
    }
    assert_eq!(info["degrees"]["3x3"], 32);
    assert_eq!(info["rational"], 0);
    let area = info["area"].as_f64().expect("a number");
    assert!((area - 52.8833).abs() < 1e-3 && info["area_relative_error"].as_f64() < Some(1e-6), "{area}");
    assert_eq!(info["bounds"][0][2], 0.0);
    assert!(info["bytes"].as_u64() > Some(32 * 16 * 32), "{}", info["bytes"]);
    assert_eq!(info["warnings"].as_array().map(Vec::len), Some(0), "{}", info["warnings"]);
    let output = halfpixel(&["info", "builtin:teapot"]);
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("52.88") && table.contains("3x3 (32)"), "{table}");
}

#[test]
fn info_measures_exactly() {
    let sphere = json(&["info", "builtin:sphere", "--json"]);
    let area = sphere["area"].as_f64().unwrap_or(0.0);
    assert!((area / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-7, "{area}");
    let turned = json(&["info", "builtin:teapot", "--json", "--up-axis", "y"]);
    assert_eq!(turned["bounds"][1][1], 0.0, "what was up is behind: {}", turned["bounds"]);
}

#[test]
fn warnings_are_listed_counted_and_with_strict_an_error() {
    let folder = Folder::new("warnings");
    let mixed = folder.file("mixed.bv", &bv_text());
    let info = json(&["info", &mixed, "--json"]);
    assert_eq!(info["warnings"].as_array().map(Vec::len), Some(3), "{}", info["warnings"]);
    assert!(error_line(&["info", &mixed, "--strict"], 1).contains("3 warnings, the first: line 28: polyhedra"));
    let whole = bpt_text(10);
    let cut = folder.file("cut.bpt", &whole[..whole.len() / 2]);
    assert_eq!(json(&["info", &cut, "--json"])["warnings"].as_array().map(Vec::len), Some(1));
    assert!(error_line(&["info", &cut, "--strict", "--json"], 1).contains("the file ends inside patch"));
}

#[test]
fn a_backend_that_is_asked_for_is_used_or_refused() {
    let folder = Folder::new("backend");
    let image = folder.path("image.png");
    let with = |backend| ["render", "builtin:sphere", "-o", &image, "--size", "32x32", "--backend", backend, "--json"];
    for backend in ["cpu", "auto"] {
        assert_eq!(json(&with(backend))["backend"], "cpu");
    }
    if halfpixel::emulated::missing().is_none() {
        assert_eq!(json(&with("emulated"))["backend"], "emulated");
        let texture =
            ["render", "builtin:trimmed:drilled", "-o", &image, "--size", "32x32", "--trim", "texture", "--json"];
        assert_eq!(json(&[&texture[..], &["--backend", "emulated"]].concat())["backend"], "emulated");
    }
    assert!(error_line(&["verify", "builtin:sphere", "--frame", "staged"], 2).contains("--backend cuda"));
    if halfpixel::cuda::missing().is_empty() {
        return;
    }
    let refused = error_line(&with("cuda"), 1);
    assert!(refused.starts_with("--backend cuda can't be used: "), "{refused}");
    assert_eq!(error_line(&["verify", "builtin:sphere", "--backend", "cuda"], 1), refused);
    assert_eq!(error_line(&["bench", "speed", "builtin:sphere", "--backend", "cuda"], 1), refused);
}

#[test]
fn devices_are_listed() {
    let devices = json(&["devices", "--json"]);
    assert_eq!(devices["devices"][0]["backend"], "cpu");
    assert!(devices["devices"][0]["threads"].as_u64() > Some(0));
    assert_eq!(halfpixel(&["devices"]).status.code(), Some(0));
    // Without a GPU it is said what is missing.
    let cuda = devices["missing"].as_array().and_then(|m| m.iter().find(|m| m["backend"] == "cuda"));
    let said = cuda.is_some_and(|c| c["reasons"].as_array().is_some_and(|r| !r.is_empty()));
    assert_eq!(said, !halfpixel::cuda::missing().is_empty());
}

#[test]
#[cfg(unix)]
fn a_closed_pipe_is_quiet() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfpixel"));
    let spawned = command.args(["info", "builtin:sphere"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = spawned.expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn render_writes_png_exr_stats_and_json() {
    let folder = Folder::new("render");
    let (png, exr, stats) = (folder.path("a.png"), folder.path("a.exr"), folder.path("stats.json"));
    let common = ["render", "builtin:teapot", "--size", "64x48", "--json"];
    let report = json(&[&common[..], &["-o", &png, "--stats", &stats]].concat());
    for (key, value) in [("backend", "cpu"), ("raster", "software"), ("bound", "screen"), ("fill", "stroke")] {
        assert_eq!(report[key], value, "{key}");
    }
    assert!(report["device"].is_string() && report["drawn"].as_u64() > Some(0), "{report}");
    let text = std::fs::read(&stats).expect("the file for stages");
    let stats: Value = serde_json::from_slice(&text).expect("JSON");
    assert!(
        stats["stages"].as_array().is_some_and(|s| s.iter().all(|s| s["stage"].is_string() && s["ms"].is_number()))
    );
    check_png(Path::new(&png));
    json(&[&common[..], &["-o", &exr]].concat());
    check_exr(Path::new(&exr));
    let left: Vec<_> = std::fs::read_dir(&folder.0).expect("the folder").flatten().map(|e| e.file_name()).collect();
    assert_eq!(left.len(), 3, "no temporary files stay: {left:?}");
}

#[test]
fn attributes_are_those_of_the_exact_surface() {
    let model = import::load("builtin:sphere").expect("a built-in model");
    let scene = prepare(&model, &|_, _| {}).expect("a scene");
    for orthographic in [false, true] {
        let view = ViewSpec { size: [96, 64], orthographic, ..ViewSpec::default() };
        let camera = view.camera(&scene.bounds).expect("a camera");
        let frame = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame");
        let pixels = attributes(&scene, &frame);
        let shown = pixels.iter().enumerate().filter(|(_, p)| p.id[0] != NO_ID);
        assert!(shown.clone().count() > 500);
        for (index, pixel) in shown {
            let center = DVec2::new((index % 96) as f64 + 0.5, (index / 96) as f64 + 0.5);
            let position = Vec3::from(pixel.position).as_dvec3();
            let normal = Vec3::from(pixel.normal).as_dvec3();
            assert!((position.length() - 1.0).abs() < 1e-6, "on the unit sphere: {position}");
            assert!((normal - position).length() < 1e-5, "{normal} at {position}, outward");
            let miss = (camera.project(camera.to_camera(position)) - center).abs().max_element();
            assert!(miss <= 0.5 + 1e-4, "{miss} px from its centre");
            assert!((f64::from(pixel.depth) - camera.to_camera(position).z).abs() < 1e-5);
        }
        let background = pixels.iter().find(|p| p.id[0] == NO_ID).expect("a corner");
        assert_eq!((background.position, background.normal, background.depth), ([0.0; 3], [0.0; 3], 0.0));
    }
}

fn check_png(path: &Path) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("the picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("a whole picture");
    assert_eq!((info.width, info.height), (64, 48));
    assert!(bytes.chunks(4).any(|p| p != &bytes[..4]), "the teapot differs from the background");
}

fn check_exr(path: &Path) {
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(path).expect("EXR");
    let channels = &image.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
    let expected = "A B G N.X N.Y N.Z P.X P.Y P.Z R Z id.face id.instance id.patch uv.U uv.V";
    assert_eq!(names.join(" "), expected);
    let real = |name: &str| match &channels[names.iter().position(|n| n == name).expect(name)].sample_data {
        FlatSamples::F32(values) => values.clone(),
        other => panic!("{name}: {other:?}"),
    };
    let number = |name: &str| match &channels[names.iter().position(|n| n == name).expect(name)].sample_data {
        FlatSamples::U32(values) => values.clone(),
        other => panic!("{name}: {other:?}"),
    };
    for name in expected.split(' ').filter(|n| !n.starts_with("id.")) {
        assert!(real(name).iter().all(|x| x.is_finite()), "{name}");
    }
    let (faces, depth) = (number("id.face"), real("Z"));
    let normal = ["N.X", "N.Y", "N.Z"].map(real);
    let shown: Vec<usize> = (0..faces.len()).filter(|&i| faces[i] != u32::MAX).collect();
    assert!(!shown.is_empty() && shown.len() < faces.len());
    for i in shown {
        let length: f32 = normal.iter().map(|n| n[i] * n[i]).sum();
        assert!(faces[i] < 32 && depth[i] > 0.0 && (length - 1.0).abs() < 1e-5, "pixel {i}");
    }
}
