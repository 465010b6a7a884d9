//! Frames with `--trim texture` by the GPU's kernels against the CPU's, word for word.

use crate::frame::{model, same, scene};
use glam::DVec3;
use halfpixel::emulated::Schedule;
use halfpixel::scene::ViewSpec;
use halfpixel::stages::{Fill, Options, Trim};

const BUILTIN: [&str; 8] = ["plate", "wedge", "drilled", "gap", "ball", "bowl", "degree22", "touching"];
const REAL: [&str; 3] = ["NIST_MBE_PMI_2.stp", "as1-oc-214.stp", "so100_Wrist_Roll_08c.step"];

fn options() -> Options {
    Options { trim: Trim::Texture, ..Options::default() }
}

#[test]
fn textured_frames_are_those_of_the_cpu() {
    for name in BUILTIN.map(|n| format!("builtin:trimmed:{n}")) {
        let scene = scene(&name);
        let mut bytes = 0;
        for fill in [Fill::Stroke, Fill::Eter] {
            for (orthographic, refine, zoom) in [(false, 2, 1.0), (true, 2, 1.0), (false, 0, 1.0), (false, 2, 8.0)] {
                let view = ViewSpec { size: [160, 120], orthographic, zoom, ..ViewSpec::default() };
                let what = format!("{name} {fill:?} {orthographic} {refine} {zoom}");
                let counts = same(&scene, &view, &Options { fill, refine, ..options() }, Schedule::default(), &what);
                bytes += counts.texture_bytes;
            }
        }
        // No loop cuts a patch of the bowl.
        assert_eq!(bytes > 0, !name.ends_with("bowl"), "{name}");
    }
}

/// Texels as large as they may be, and larger than they should.
#[test]
fn textures_too_coarse_are_counted_alike() {
    let scene = scene("builtin:trimmed:plate");
    // The rim of a hole.
    let target = DVec3::new(0.225, 0.125, 0.0);
    let (eye, target) = (Some(target + DVec3::new(0.1, 0.2, 5.0)), Some(target));
    let view = ViewSpec { size: [96, 64], orthographic: true, zoom: 150.0, eye, target, ..ViewSpec::default() };
    let options = Options { tolerance: 0.2, ..options() };
    let counts = same(&scene, &view, &options, Schedule::default(), "zoomed");
    assert!(counts.textures_too_coarse > 0 && counts.tested > counts.rejected && counts.rejected > 0, "{counts:?}");
}

#[test]
fn real_models_are_drawn_alike_by_textures() {
    for name in REAL {
        let Some(file) = model(name) else { continue };
        let scene = scene(&file);
        for (orthographic, zoom) in [(false, 1.0), (true, 8.0)] {
            let view = ViewSpec { size: [160, 120], orthographic, zoom, ..ViewSpec::default() };
            same(&scene, &view, &options(), Schedule::default(), &format!("{name} {orthographic} {zoom}"));
        }
    }
}

#[test]
fn textured_frames_are_the_same_in_any_order() {
    let scene = scene("builtin:trimmed:drilled");
    let view = ViewSpec { size: [80, 60], ..ViewSpec::default() };
    for schedule in Schedule::adversarial() {
        same(&scene, &view, &options(), schedule, &format!("{schedule:?}"));
    }
}
