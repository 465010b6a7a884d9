//! Hard views of hard models before the oracle.

use glam::DVec3;
use halfpixel::import::builtin::builtin;
use halfpixel::scene::{ViewSpec, prepare};
use halfpixel::stages::{Options, Renderer};
use halfpixel::verify::{Report, Sampling, verify};

/// The oracle on every pixel of a built-in model.
fn judged(name: &str, spec: ViewSpec) -> Report {
    let scene = prepare(&builtin(name).expect(name), &|_, _| {}).expect("a scene");
    let camera = spec.camera(&scene.bounds).expect("a camera");
    let frame = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame");
    verify(&scene, &camera, &Options::default(), &|x, y| frame.pixel(x, y), &Sampling::default(), &|_, _| {})
}

/// 480 x 320 pixels from an eye towards a target.
fn from(eye: [f64; 3], target: [f64; 3]) -> ViewSpec {
    let [eye, target] = [eye, target].map(|p| Some(DVec3::from_array(p)));
    ViewSpec { size: [480, 320], eye, target, ..ViewSpec::default() }
}

/// Leaves next to the near plane are a thousandth of their patch: refinement must not follow their f32 nets far out.
#[test]
fn a_ribbon_through_the_near_plane_is_refined() {
    let report = judged("stress:nearplane", from([0.0, 0.0, 0.0], [10.0, 0.1, 0.2]));
    let refined = report.refined_error_px.map_or(0.0, |e| e.max);
    assert!(refined < 0.05, "{refined} px");
}

/// Depths of neighbours differ by f32 rounding alone there: that is no failure.
#[test]
fn seams_keep_their_depth_at_a_ten_million_fold_zoom() {
    let spec = ViewSpec { size: [480, 320], zoom: 1e7, target: Some(DVec3::new(1.0, 0.0, 0.4)), ..ViewSpec::default() };
    let report = judged("torus", spec);
    assert_eq!(report.depth_failures, 0, "{:?}", report.worst);
}
