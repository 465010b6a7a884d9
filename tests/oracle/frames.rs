//! Frames made by the oracle itself pass; frames broken on purpose are caught, with the right kind and count.

use crate::shapes::{self, Part};
use glam::DVec3;
use halfpixel::import::builtin::builtin;
use halfpixel::scene::{Camera, Scene, View, ViewSpec, prepare};
use halfpixel::stages::{Options, Pixel, Renderer};
use halfpixel::verify::{Class, Failure, Hit, Oracle, Report, Sampling, verify};

/// A frame as a list.
pub struct Picture {
    pub scene: Scene,
    camera: Camera,
    pixels: Vec<Option<Pixel>>,
}

fn shown(camera: &Camera, hit: &Hit) -> Pixel {
    Pixel {
        instance: hit.instance,
        patch: hit.patch,
        interpolated: [hit.u, hit.v],
        stored: [hit.u, hit.v],
        depth: camera.stored_depth(hit.depth) as f32,
        filled: false,
    }
}

impl Picture {
    /// What the nearest hits at the pixel centres show.
    pub fn perfect(scene: Scene, camera: Camera) -> Self {
        let oracle = Oracle::new(&scene, &camera);
        let [w, h] = camera.size;
        let pixels = (0..w * h)
            .map(|i| oracle.hits(f64::from(i % w) + 0.5, f64::from(i / w) + 0.5).first().map(|h| shown(&camera, h)))
            .collect();
        Self { scene, camera, pixels }
    }

    pub fn at(&mut self, x: u32, y: u32) -> &mut Option<Pixel> {
        &mut self.pixels[(y * self.camera.size[0] + x) as usize]
    }

    pub fn verify(&self, sampling: Sampling) -> Report {
        let pixels = |x: u32, y: u32| self.pixels[(y * self.camera.size[0] + x) as usize];
        verify(&self.scene, &self.camera, &Options::default(), &pixels, &sampling, &|_, _| {})
    }

    pub fn report(&self) -> Report {
        self.verify(Sampling::default())
    }
}

/// [violations, cracks, covering failures, depth failures]
pub fn failures(report: &Report) -> [u64; 4] {
    [report.violations, report.cracks, report.covering_failures, report.depth_failures]
}

/// A square of 60 px that faces the camera, of two patches and faces 0 and 1, and a larger one behind it, face 2, whose
/// left border is at x = 10.2. A pixel is 0.1 units.
fn squares() -> Picture {
    let square = |x: f64, depth: f64, w: f64, h: f64, face| {
        shapes::plane(DVec3::new(x, depth, -h / 2.0), DVec3::X * w, DVec3::Z * h, face)
    };
    let parts: [Part; 3] =
        [square(-3.0, 0.0, 3.0, 6.0, 0), square(0.0, 0.0, 3.0, 6.0, 1), square(-3.98, 5.0, 7.98, 8.0, 2)];
    Picture::perfect(shapes::scene(&parts, DVec3::ZERO), shapes::front([100, 100], 10.0))
}

fn sphere(orthographic: bool) -> Picture {
    let scene = shapes::scene(&shapes::sphere(1.0), DVec3::ZERO);
    let camera = shapes::camera(&scene, [160, 120], orthographic);
    Picture::perfect(scene, camera)
}

#[test]
fn perfect_frames_pass() {
    let torus = shapes::scene(&shapes::torus(2.0, 0.8), DVec3::ZERO);
    let camera = shapes::camera(&torus, [160, 120], false);
    for picture in [squares(), sphere(false), sphere(true), Picture::perfect(torus, camera)] {
        let report = picture.report();
        assert_eq!(failures(&report), [0; 4], "{:?}", report.worst);
        assert_eq!(report.pixels, picture.pixels.len() as u64);
        assert_eq!(report.drawn, picture.pixels.iter().flatten().count() as u64);
        let refined = report.refined_error_px.unwrap();
        assert!(refined.max < 1e-3 && refined.mean < 1e-5, "{refined:?}");
        assert!(report.passed());
    }
}

#[test]
fn shifted_parameters_are_violations() {
    let mut picture = squares();
    // Patch 0 is 30 px wide in u.
    for (x, shift) in [(30, 0.49), (31, 0.51), (32, 3.0)] {
        let pixel = picture.at(x, 50).as_mut().unwrap();
        assert_eq!(pixel.patch, 0);
        pixel.stored[0] += shift / 30.0;
    }
    picture.at(33, 50).as_mut().unwrap().interpolated[0] -= 0.6 / 30.0;
    let report = picture.report();
    assert_eq!(failures(&report), [3, 0, 0, 0], "{:?}", report.worst);
    assert!((report.parametric_error_px.unwrap().max - 3.0).abs() < 1e-6);
    assert!((report.grid_error_px.unwrap().max - 0.6).abs() < 1e-6);
    let worst = &report.worst[0];
    assert_eq!((worst.kind, worst.x, worst.y, worst.patch), (Failure::Violation, 32, 50, Some(0)));
    assert_eq!(report.map.at(32, 50), Class::Beyond);
    assert_eq!(report.map.at(31, 50), Class::Whole);
    assert_eq!(report.map.at(29, 50), Class::Tenth);
}

#[test]
fn a_filled_pixel_has_no_grid_error() {
    let mut picture = squares();
    let pixel = picture.at(30, 50).as_mut().unwrap();
    (pixel.filled, pixel.interpolated[0]) = (true, 0.9);
    // Strokes are pushed back in the buffer.
    pixel.depth -= 0.02;
    let report = picture.report();
    assert_eq!((failures(&report), report.filled), ([0; 4], 1));
}

#[test]
fn holes_are_cracks() {
    let mut picture = squares();
    // To the background inside the surface, and at a border where some sub-samples miss everything.
    *picture.at(45, 45) = None;
    *picture.at(46, 45) = None;
    *picture.at(10, 50) = None;
    let report = picture.report();
    assert_eq!(failures(&report), [0, 2, 0, 0], "{:?}", report.worst);
    assert_eq!(report.map.at(45, 45), Class::Crack);
}

/// The pixel at (x, y) shows hit number `index` of its centre ray.
fn show_hidden(picture: &mut Picture, x: u32, y: u32, index: usize) {
    let hit = Oracle::new(&picture.scene, &picture.camera).hits(f64::from(x) + 0.5, f64::from(y) + 0.5)[index];
    *picture.at(x, y) = Some(shown(&picture.camera, &hit));
}

#[test]
fn a_hidden_face_is_a_crack_and_not_covered() {
    let mut picture = squares();
    show_hidden(&mut picture, 40, 40, 1);
    let report = picture.report();
    assert_eq!(failures(&report), [0, 1, 1, 0], "{:?}", report.worst);
}

#[test]
fn a_hidden_sheet_of_a_visible_face_is_a_depth_failure() {
    let mut picture = sphere(false);
    show_hidden(&mut picture, 80, 60, 1);
    let report = picture.report();
    assert_eq!(failures(&report), [0, 1, 0, 1], "{:?}", report.worst);
}

#[test]
fn a_wrong_depth_is_a_depth_failure() {
    for orthographic in [false, true] {
        let mut picture = sphere(orthographic);
        let camera = picture.camera;
        let pixel = picture.at(80, 60).as_mut().unwrap();
        let z = camera.camera_depth(f64::from(pixel.depth)) + 3.0 * camera.pixel_size(camera.near);
        pixel.depth = camera.stored_depth(z) as f32;
        let report = picture.report();
        assert_eq!(failures(&report), [0, 0, 0, 1], "{:?}", report.worst);
    }
}

#[test]
fn a_wrong_patch_is_not_covered() {
    let mut picture = squares();
    // The same depth, the neighbour's face: in the middle of the patch, and within half a pixel of the seam (x = 50).
    for x in [40, 49] {
        let pixel = picture.at(x, 50).as_mut().unwrap();
        pixel.patch = 1;
        pixel.stored[0] = 0.0;
        pixel.interpolated = pixel.stored;
    }
    let report = picture.report();
    assert_eq!(failures(&report), [1, 0, 1, 0], "{:?}", report.worst);
    assert_eq!(report.map.at(40, 50), Class::CoveringFailure);
}

#[test]
fn patches_that_do_not_exist_are_caught() {
    let mut picture = squares();
    for (x, patch, u) in [(40, 99, 0.5), (41, 0, f64::NAN)] {
        let pixel = picture.at(x, 50).as_mut().unwrap();
        (pixel.patch, pixel.stored[0]) = (patch, u);
    }
    let report = picture.report();
    assert_eq!(report.violations, 2);
    assert_eq!(report.covering_failures, 1);
    assert!(serde_json::to_string(&report).is_ok());
}

#[test]
fn samples_find_failures_at_seams_and_fills() {
    let mut picture = squares();
    // Next to a filled pixel.
    picture.at(35, 50).as_mut().unwrap().filled = true;
    *picture.at(36, 51) = None;
    let report = picture.verify(Sampling { samples: Some(20), seed: 1 });
    assert_eq!(failures(&report), [0, 1, 0, 0]);
    assert!(report.pixels < 60);
    assert_eq!(report.filled, 1);
}

#[test]
fn an_empty_scene_is_background() {
    let camera = shapes::front([20, 10], 1.0);
    let picture = Picture { scene: Scene::default(), camera, pixels: vec![None; 200] };
    let report = picture.report();
    assert_eq!((report.pixels, report.drawn, report.passed()), (200, 0, true));
    assert!(report.grid_error_px.is_none());
    let mut png = Vec::new();
    report.map.write_png(&mut png).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (20, 10));
}

/// Beside folds the map to the screen can hardly be inverted; refinement gets there all the same.
#[test]
fn refinement_reaches_the_surface_on_folds() {
    for name in ["torus", "teapot", "sphere"] {
        let scene = prepare(&builtin(name).expect(name), &|_, _| {}).expect(name);
        for view in View::ALL {
            for orthographic in [false, true] {
                let spec = ViewSpec { size: [640, 360], view, orthographic, ..ViewSpec::default() };
                let camera = spec.camera(&scene.bounds).expect("a camera");
                let frame = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame");
                let pixels = |x, y| frame.pixel(x, y);
                let report = verify(&scene, &camera, &Options::default(), &pixels, &Sampling::default(), &|_, _| {});
                let refined = report.refined_error_px.map_or(0.0, |e| e.max);
                assert!(refined <= 0.01, "{name} {view:?}: {refined} px");
            }
        }
    }
}
