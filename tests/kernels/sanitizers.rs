//! Races and accesses beyond memory, found by the compiler's sanitizers: in kernels that have them on purpose, and none in the
//! kernels of whole frames.

use crate::skip::skip;
use halfpixel::emulated::{Device, Schedule};
use halfpixel::import;
use halfpixel::scene::{ViewSpec, prepare};
use halfpixel::stages::{Bound, Engine, Fill, FrameShape, Options, Precision, Renderer, Trim};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the script; what this compiler can't do it says, with `skipped`.
#[test]
fn sanitizers_find_what_they_must_and_nothing_else() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sanitize_kernels");
    fs::create_dir_all(&folder).expect("a folder");
    let mut recordings = Vec::new();
    // Together all kernels of frames: those for patches that are split, for tensor cores, for textures, for other bounds and
    // ways to fill, too.
    let (near, other) = (40.0, Options { bound: Bound::Eter, fill: Fill::Eter, ..Options::default() });
    let texture = Options { trim: Trim::Texture, precision: Precision::Auto, ..Options::default() };
    for (name, zoom, options) in
        [("trimmed:drilled", 1.0, Options::default()), ("trimmed:ball", 1.0, texture), ("teapot", near, other)]
    {
        for frame in [FrameShape::Staged, FrameShape::Fused] {
            recordings.push(record(&folder, name, zoom, &Options { frame, ..options }));
        }
    }
    let mut script = Command::new("bash");
    script.arg(root.join("scripts/sanitize_kernels.sh")).arg(&folder).args(&recordings);
    let output = script.output().expect("bash can be started");
    let [out, error] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    println!("{out}{error}");
    assert!(output.status.success(), "{out}{error}");
    for sanitizer in ["thread", "address", "undefined"] {
        let told = |line: &str| line.starts_with(&format!("{sanitizer}:"));
        assert!(out.lines().any(told), "nothing was said of the {sanitizer} sanitizer:\n{out}");
    }
    out.lines().filter(|line| line.contains(": skipped, ")).for_each(skip);
}

/// Draws a small frame and writes down every launch; where it is fused, that of the next frame too, which asks for nothing.
fn record(folder: &Path, name: &str, zoom: f64, options: &Options) -> PathBuf {
    let model = import::load(&format!("builtin:{name}")).expect("a model");
    let scene = prepare(&model, &|_, _| {}).expect("a scene");
    let camera = ViewSpec { size: [48, 36], zoom, ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
    // Blocks one after the other, so that lists come in the same order again.
    let mut device = Device::new(Schedule::default(), 1);
    let recording = device.record();
    let mut renderer = Renderer::with(&scene, Engine::Emulated(Box::new(device)));
    for _ in 0..if options.frame == FrameShape::Fused { 2 } else { 1 } {
        renderer.render(&camera, options).expect("a frame");
    }
    let Options { frame, bound, .. } = options;
    let path = folder.join(format!("{}-{zoom}-{frame:?}-{bound:?}.launches", name.replace(':', "-")));
    fs::write(&path, recording.bytes()).expect("room for a recording");
    path
}
