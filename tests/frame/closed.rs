//! Closed solids against their formulas: wrong pixels are counted, and there are none.

use super::support::*;
use glam::{DVec2, DVec3};
use halfpixel::scene::{Camera, ViewSpec};
use halfpixel::stages::{Grid, Options, Show};

const SIZE: [u32; 2] = [160, 120];

/// Views at which the solid fills the picture more and more.
fn views() -> impl Iterator<Item = ViewSpec> {
    let one = |k: usize| ViewSpec {
        size: SIZE,
        zoom: [0.3, 1.0, 2.5, 12.0][k / 2],
        orthographic: k % 2 == 1,
        eye: Some(DVec3::new(3.1, -2.3, 1.7)),
        target: Some(DVec3::new(0.0, 0.2, 0.1)),
        ..ViewSpec::default()
    };
    (0..8).map(one)
}

fn is_in_torus(p: DVec3) -> bool {
    (p.truncate().length() - 1.0).powi(2) + p.z * p.z < 0.16
}

/// Nearest point of the unit sphere on the ray.
fn on_sphere(camera: &Camera, at: DVec2) -> Option<DVec3> {
    let (origin, step) = ray(camera, at);
    let (a, b, c) = (step.length_squared(), origin.dot(step), origin.length_squared() - 1.0);
    let root = (b * b - a * c).sqrt();
    // Not a number where the ray misses.
    (root >= 0.0).then(|| origin + step * ((-b - root) / a))
}

/// Some point of the ray is inside the torus: sure where it says so, since nothing is said of what lies between samples.
fn meets_torus(camera: &Camera, at: DVec2) -> bool {
    let (origin, step) = ray(camera, at);
    let middle = camera.eye.length();
    (0..=400).any(|k| is_in_torus(origin + step * (middle + (f64::from(k) / 200.0 - 1.0) * 1.5)))
}

/// Pixels that the solid covers, and those of them that show the background.
fn open_pixels(name: &str, spec: ViewSpec, grid: Grid, covers: fn(&Camera, DVec2) -> bool) -> [usize; 2] {
    let scene = scene(name);
    let camera = camera(&scene, spec);
    let frame = render(&scene, &camera, &Options { grid, ..Options::default() });
    let covered = pixels(SIZE).filter(|&at| subsamples(at).all(|s| covers(&camera, s)));
    let drawn = covered.map(|[x, y]| frame.pixel(x, y).is_some());
    drawn.fold([0, 0], |[all, open], drawn| [all + 1, open + usize::from(!drawn)])
}

#[test]
fn every_pixel_inside_a_silhouette_is_drawn() {
    type Covers = fn(&Camera, DVec2) -> bool;
    let solids: [(&str, Covers); 2] =
        [("sphere", |camera, at| on_sphere(camera, at).is_some()), ("torus", meets_torus)];
    for (name, covers) in solids {
        let mut covered = 0;
        for (spec, grid) in views().flat_map(|spec| [(spec, Grid::Adaptive), (spec, Grid::Eter)]) {
            let [all, open] = open_pixels(name, spec, grid, covers);
            assert_eq!(open, 0, "{name}, {grid:?}, of {all} pixels: {spec:?}");
            covered += all;
        }
        assert!(covered > 50_000, "{name}: {covered} pixels");
    }
}

/// What the closed form says of the square of a pixel that the sphere fills.
struct Exact {
    points: Vec<DVec3>,
}

impl Exact {
    fn of(camera: &Camera, at: [u32; 2]) -> Option<Self> {
        Some(Self { points: subsamples(at).map(|s| on_sphere(camera, s)).collect::<Option<_>>()? })
    }

    /// Smallest and largest value over the square's sub-samples.
    fn range(&self, value: impl Fn(DVec3) -> f64) -> [f64; 2] {
        let values = self.points.iter().map(|&p| value(p));
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    }
}

fn is_within(value: f64, [low, high]: [f64; 2], slack: f64) -> bool {
    (low - slack..=high + slack).contains(&value)
}

#[test]
fn a_sphere_has_the_right_patch_depth_and_normal_in_every_pixel() {
    let scene = scene("sphere");
    // Each of the eight patches is an octant.
    let octant = |p: DVec3| p.to_array().map(|c| c > 0.0);
    let octant_of = |patch: u32| {
        let patch = &scene.patches[patch as usize];
        octant(scene.net(patch).position(0.5, 0.5) + patch.origin)
    };
    let (mut checked, mut wrong) = (0, [0; 4]);
    for spec in views() {
        let camera = camera(&scene, spec);
        let frame = render(&scene, &camera, &Options { show: Show::Normals, ..Options::default() });
        for at in pixels(SIZE) {
            let Some(exact) = Exact::of(&camera, at) else { continue };
            let Some(pixel) = frame.pixel(at[0], at[1]) else {
                wrong[0] += 1;
                continue;
            };
            checked += 1;
            // The patch is one that shows somewhere in the pixel.
            wrong[0] += usize::from(!exact.points.iter().any(|&p| octant(p) == octant_of(pixel.patch)));
            // Stored depth may be off by a pixel's size; where strokes decided it is pushed back on purpose.
            let depths = exact.range(|p| camera.to_camera(p).z);
            let found = camera.camera_depth(f64::from(pixel.depth));
            let tolerance = camera.pixel_size(depths[1]) + 1e-6 * depths[1];
            wrong[1] += usize::from(!pixel.filled && !is_within(found, depths, tolerance));
            let refined = in_camera(&scene, &camera, &pixel, pixel.stored).z;
            wrong[2] += usize::from(!is_within(refined, depths, tolerance));
            // The picture of normals: x, -y, -z of the camera's axes, from [-1, 1] to [0, 1].
            let color = frame.color(at[0], at[1]);
            let axes = [camera.right * 0.5, camera.down * -0.5, camera.forward * -0.5];
            let right = (0..3).all(|k| is_within(f64::from(color[k]) - 0.5, exact.range(|p| p.dot(axes[k])), 2e-3));
            wrong[3] += usize::from(!right);
        }
    }
    assert!(checked > 30_000, "{checked} pixels");
    assert_eq!(wrong, [0; 4], "patch, depth, refined depth, normal; of {checked} pixels");
}
