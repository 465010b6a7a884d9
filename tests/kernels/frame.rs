//! Whole frames by the GPU's kernels against the CPU's, word for word.

use halfpixel::emulated::{Device, Schedule};
use halfpixel::import;
use halfpixel::scene::{Scene, ViewSpec, prepare};
use halfpixel::stages::{Bound, Engine, Fill, Frame, FrameShape, Options, Renderer, Show, TrimCounts};
use std::path::{Path, PathBuf};

const REAL: [&str; 8] = [
    "11752.stp",
    "777-200LR.stp",
    "NIST_MBE_PMI_2.stp",
    "as1-oc-214.stp",
    "gmsh_submarine.stp",
    "killeroo.bpt",
    "so100_Wrist_Roll_08c.step",
    "ublox_ANN-MB-00_SMA.stp",
];

pub fn scene(name: &str) -> Scene {
    prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene")
}

/// Words, parameters and colours of both frames are the same; returns what trimming did on the CPU.
pub fn same(scene: &Scene, view: &ViewSpec, options: &Options, schedule: Schedule, what: &str) -> TrimCounts {
    let counts = [FrameShape::Staged, FrameShape::Fused]
        .map(|frame| same_in(scene, view, &Options { frame, ..*options }, schedule, &format!("{frame:?} {what}")));
    counts[0]
}

/// A frame is the CPU's.
pub fn expect_same(found: &Frame, expected: &Frame, what: &str) {
    let [width, height] = expected.size();
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let different: Vec<_> = pixels.filter(|&(x, y)| differ(found, expected, x, y)).collect();
    let show =
        |frame: &Frame, (x, y)| format!("{:x} {:?} {:?}", frame.word(x, y), frame.pixel(x, y), frame.color(x, y));
    let first: Vec<String> = (different.iter().take(3))
        .map(|&at| format!("{at:?}: {}\n  instead of {}", show(found, at), show(expected, at)))
        .collect();
    assert!(different.is_empty(), "{what}: {} pixels differ\n{}", different.len(), first.join("\n"));
    assert_eq!(found.stats.filled, expected.stats.filled, "{what}");
    assert_eq!(found.stats.drawn, expected.stats.drawn, "{what}");
}

fn same_in(scene: &Scene, view: &ViewSpec, options: &Options, schedule: Schedule, what: &str) -> TrimCounts {
    let camera = view.camera(&scene.bounds).expect("a camera");
    let expected = Renderer::new(scene).render(&camera, options).expect("a frame");
    let engine = Engine::Emulated(Box::new(Device::new(schedule, 2)));
    let found = Renderer::with(scene, engine).render(&camera, options).expect("no fault");
    expect_same(&found, &expected, what);
    let textures = |frame: &Frame| [frame.stats.trim.textures_too_coarse, frame.stats.trim.texture_bytes];
    assert_eq!(textures(&found), textures(&expected), "{what}");
    expected.stats.trim
}

fn differ(a: &Frame, b: &Frame, x: u32, y: u32) -> bool {
    a.word(x, y) != b.word(x, y) || a.pixel(x, y) != b.pixel(x, y) || a.color(x, y) != b.color(x, y)
}

#[test]
fn frames_are_those_of_the_cpu() {
    for name in ["builtin:teapot", "builtin:torus", "builtin:stress"] {
        let scene = scene(name);
        for bound in [Bound::Screen, Bound::Eter] {
            for fill in [Fill::Stroke, Fill::Eter, Fill::Conservative, Fill::Off] {
                for (orthographic, refine, zoom) in [(false, 2, 1.0), (true, 2, 1.0), (false, 0, 1.0), (false, 2, 8.0)]
                {
                    let view = ViewSpec { size: [160, 120], orthographic, zoom, ..ViewSpec::default() };
                    let options = Options { bound, fill, refine, ..Options::default() };
                    let what = format!("{name} {bound:?} {fill:?} {orthographic} {refine} {zoom}");
                    same(&scene, &view, &options, Schedule::default(), &what);
                }
            }
        }
    }
}

#[test]
fn trimmed_frames_are_those_of_the_cpu() {
    for name in ["plate", "wedge", "drilled", "gap", "ball", "bowl", "degree22", "touching"]
        .map(|n| format!("builtin:trimmed:{n}"))
    {
        let scene = scene(&name);
        for fill in [Fill::Stroke, Fill::Eter] {
            for (orthographic, refine, zoom) in [(false, 2, 1.0), (true, 2, 1.0), (false, 0, 1.0), (false, 2, 8.0)] {
                let view = ViewSpec { size: [160, 120], orthographic, zoom, ..ViewSpec::default() };
                let options = Options { fill, refine, ..Options::default() };
                same(
                    &scene,
                    &view,
                    &options,
                    Schedule::default(),
                    &format!("{name} {fill:?} {orthographic} {refine} {zoom}"),
                );
            }
        }
    }
}

/// Where a real file is, if it is there.
pub fn model(name: &str) -> Option<String> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let path = std::env::var_os("HALFPIXEL_MODELS").map_or(beside, PathBuf::from).join(name);
    let file = path.to_str().filter(|_| path.is_file()).map(str::to_owned);
    if file.is_none() {
        eprintln!("skipped: there is no {} (set HALFPIXEL_MODELS)", path.display());
    }
    file
}

/// Real files, where there are any: assemblies, instances, mirrored solids, thousands of faces.
#[test]
fn real_models_are_drawn_alike() {
    for name in REAL {
        let Some(file) = model(name) else { continue };
        let scene = scene(&file);
        for (orthographic, zoom) in [(false, 1.0), (true, 8.0)] {
            let view = ViewSpec { size: [160, 120], orthographic, zoom, ..ViewSpec::default() };
            same(&scene, &view, &Options::default(), Schedule::default(), &format!("{name} {orthographic} {zoom}"));
        }
    }
}

/// Triangles that many warps draw: across the whole image, trimmed and not.
#[test]
fn large_triangles_are_drawn_alike() {
    for (name, zoom) in
        [("teapot", 300.0), ("drum", 30.0), ("trimmed:plate", 4.0), ("trimmed:drilled", 20.0), ("trimmed:wedge", 1.0)]
    {
        let scene = scene(&format!("builtin:{name}"));
        for orthographic in [false, true] {
            let view = ViewSpec { size: [400, 300], zoom, orthographic, ..ViewSpec::default() };
            same(&scene, &view, &Options::default(), Schedule::default(), &format!("{name} {orthographic}"));
        }
    }
}

/// What a frame did is the same picture, settled pixels included.
#[test]
fn pictures_that_explain_are_drawn_alike() {
    let scene = scene("builtin:trimmed:drilled");
    let view = ViewSpec { size: [96, 64], ..ViewSpec::default() };
    for show in [Show::Patches, Show::Grid, Show::Meshlets, Show::Normals, Show::Depth, Show::Error, Show::TriangleSize]
    {
        same(&scene, &view, &Options { show, ..Options::default() }, Schedule::default(), &format!("{show:?}"));
    }
}

#[test]
fn frames_are_the_same_in_any_order() {
    let scene = scene("builtin:trimmed:drilled");
    let view = ViewSpec { size: [80, 60], ..ViewSpec::default() };
    for schedule in Schedule::adversarial() {
        same(&scene, &view, &Options::default(), schedule, &format!("{schedule:?}"));
    }
}
