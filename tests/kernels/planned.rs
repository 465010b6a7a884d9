//! Frames that follow others: they ask the device for nothing before their end, and are the CPU's all the same.

use crate::frame::{expect_same, model};
use halfpixel::emulated::{Device, Schedule};
use halfpixel::import;
use halfpixel::scene::{Scene, ViewSpec, prepare};
use halfpixel::stages::{Bound, Engine, Fill, FrameShape, Grid, Options, Precision, Renderer, Stats};

fn scene(name: &str) -> Scene {
    prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene")
}

/// Frames of one renderer, zoom by zoom; whether each had to ask.
fn frames(scene: &Scene, options: &Options, schedule: Schedule, zooms: &[f64], what: &str) -> Vec<bool> {
    let engine = Engine::Emulated(Box::new(Device::new(schedule, 2)));
    let mut renderer = Renderer::with(scene, engine);
    let mut asked = Vec::new();
    for &zoom in zooms {
        let view = ViewSpec { size: [120, 90], zoom, ..ViewSpec::default() };
        let camera = view.camera(&scene.bounds).expect("a camera");
        let found = renderer.render(&camera, options).expect("a frame");
        asked.push(found.stats.asked);
        if options.precision == Precision::F32 {
            let expected = Renderer::new(scene).render(&camera, options).expect("a frame");
            expect_same(&found, &expected, &format!("{what}, zoom {zoom}, {options:?}"));
            let counts = |s: &Stats| (s.patches_visible, s.leaves, s.meshlets, s.quads, s.trim.meshlets_outside);
            assert_eq!(counts(&found.stats), counts(&expected.stats), "{what}, zoom {zoom}");
        } else {
            let engine = Engine::Emulated(Box::new(Device::new(schedule, 2)));
            let first = Renderer::with(scene, engine).render(&camera, options).expect("a frame");
            assert!(first.stats.asked);
            expect_same(&found, &first, &format!("{what}, zoom {zoom}, {options:?}"));
        }
    }
    asked
}

#[test]
fn later_frames_ask_for_nothing() {
    let zooms = [1.0, 1.0, 1.05, 1.0];
    for name in ["teapot", "torus", "stress", "trimmed:drilled", "trimmed:ball"].map(|n| format!("builtin:{n}")) {
        let scene = scene(&name);
        for frame in [FrameShape::Fused, FrameShape::Staged] {
            for precision in [Precision::F32, Precision::Auto] {
                let options = Options { frame, precision, ..Options::default() };
                let asked = frames(&scene, &options, Schedule::default(), &zooms, &name);
                // A little closer, some list may have outgrown its room.
                assert!(asked[0] && !asked[1] && !asked[3], "{asked:?} {name}, {options:?}");
            }
        }
        for fill in [Fill::Eter, Fill::Conservative, Fill::Off] {
            let options = Options { fill, bound: Bound::Eter, grid: Grid::Eter, ..Options::default() };
            assert!(!frames(&scene, &options, Schedule::default(), &[1.0, 1.0], &name)[1], "{name}, {options:?}");
        }
    }
}

/// Whatever there is no room for, the frame is drawn again.
#[test]
fn frames_that_outgrow_the_last_one_ask_again() {
    let zooms = [0.02, 4.0, 60.0, 4.0];
    for name in ["teapot", "torus", "trimmed:drilled", "trimmed:degree22"].map(|n| format!("builtin:{n}")) {
        let scene = scene(&name);
        for (frame, precision) in [
            (FrameShape::Fused, Precision::F32),
            (FrameShape::Staged, Precision::F32),
            (FrameShape::Fused, Precision::F16),
            (FrameShape::Staged, Precision::Auto),
        ] {
            let options = Options { frame, precision, tolerance: 0.1, ..Options::default() };
            let asked = frames(&scene, &options, Schedule::default(), &zooms, &name);
            assert!(asked[0] && asked[1] && !asked[3], "{name}: {asked:?}");
        }
    }
}

#[test]
fn later_frames_are_the_same_in_any_order() {
    let scene = scene("builtin:trimmed:drilled");
    for schedule in Schedule::adversarial() {
        frames(&scene, &Options::default(), schedule, &[0.1, 1.0, 1.1], &format!("{schedule:?}"));
    }
}

#[test]
fn real_models_are_drawn_again() {
    for name in ["11752.stp", "killeroo.bpt", "so100_Wrist_Roll_08c.step"] {
        let Some(file) = model(name) else { continue };
        let asked = frames(&scene(&file), &Options::default(), Schedule::default(), &[1.0, 1.02, 9.0, 1.0], name);
        assert!(asked[0] && !asked[1] && !asked[3], "{name}: {asked:?}");
    }
}
