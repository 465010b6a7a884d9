//! Real STEP files, every pixel of views that were wrong once.

mod support;

use halfpixel::import::load;
use halfpixel::scene::{View, ViewSpec, prepare};
use halfpixel::stages::{Options, Renderer};
use halfpixel::verify::{Sampling, verify};

/// No violation, crack, covering or depth failure; refined to 0.01 px.
fn keeps_the_contract(name: &str, view: View, zoom: f64) {
    let Some(path) = support::real_model(name) else { return };
    let model = load(path.to_str().expect("a path in UTF-8")).expect(name);
    let scene = prepare(&model, &|_, _| {}).expect(name);
    let spec = ViewSpec { size: [640, 480], view, zoom, ..ViewSpec::default() };
    let camera = spec.camera(&scene.bounds).expect("a camera");
    let frame = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame");
    let pixels = |x, y| frame.pixel(x, y);
    let report = verify(&scene, &camera, &Options::default(), &pixels, &Sampling::default(), &|_, _| {});
    let failures = [report.violations, report.cracks, report.covering_failures, report.depth_failures];
    assert_eq!(failures, [0; 4], "{name} {view:?} {zoom}: {:?}", report.worst);
    assert!(report.refined_error_px.map_or(0.0, |e| e.max) <= 0.01, "{name} {view:?} {zoom}");
}

/// A trim curve with a turn in its first thousandth went as its chord, a pixel or two inside.
#[test]
fn trim_curves_are_no_chords() {
    keeps_the_contract("ublox_ANN-MB-00_SMA.stp", View::Top, 8.0);
    keeps_the_contract("so100_Wrist_Roll_08c.step", View::Right, 64.0);
    keeps_the_contract("axom_boxed_sphere.step", View::Iso, 8.0);
}

/// A steep wall ends at a trimmed plane; strokes of half the tolerance did not reach it.
#[test]
fn steep_walls_meet_trimmed_planes() {
    keeps_the_contract("so100_Wrist_Roll_08c.step", View::Iso, 8.0);
    keeps_the_contract("NIST_MBE_PMI_2.stp", View::Top, 1.0);
    keeps_the_contract("11752.stp", View::Iso, 1.0);
}

/// Refinement ends up to 1/512 px outside a face's trim; of some faces there nothing but the edge is in sight.
#[test]
fn edges_of_hidden_faces_may_be_shown() {
    keeps_the_contract("kicad_Molex_SlimStack_54722-0804_2x40.step", View::Left, 8.0);
}

/// A wall is seen nearly along and its grid reaches beyond its border, where refinement stops and another face hides it:
/// the pixel goes to what lies exactly under its centre.
#[test]
fn walls_end_where_they_are_hidden() {
    keeps_the_contract("NIST_MBE_PMI_2.stp", View::Left, 1.0);
}
