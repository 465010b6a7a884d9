//! Near planes, eyes inside, degenerate patches, models far from the origin.

use crate::shapes::{self, Part, Random};
use glam::{DVec3, DVec4};
use halfpixel::scene::{Camera, Projection, Scene};
use halfpixel::verify::Oracle;

/// Perspective, at `eye`, looking along +y.
fn perspective(eye: DVec3, focal: f64, near: f64) -> Camera {
    let projection = Projection::Perspective { focal };
    Camera { eye, projection, near, ..shapes::front([100, 100], 1.0) }
}

fn grid(camera: &Camera, step: usize) -> impl Iterator<Item = (f64, f64)> {
    let [w, h] = camera.size;
    (0..h)
        .step_by(step)
        .flat_map(move |y| (0..w).step_by(step).map(move |x| (f64::from(x) + 0.37, f64::from(y) + 0.61)))
}

/// Depths at which the line of the ray enters and leaves the unit sphere.
fn sphere_depths(camera: &Camera, x: f64, y: f64) -> Vec<f64> {
    let (o, d) = shapes::ray(camera, x, y);
    let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
    let root = (b * b - a * c).sqrt();
    [(-b - root) / a, (-b + root) / a].into_iter().filter(|z| z.is_finite()).collect()
}

#[test]
fn near_plane_and_eye_inside() {
    let scene = shapes::scene(&shapes::sphere(1.0), DVec3::ZERO);
    for (eye, focal, near) in [
        (DVec3::new(0.1, -3.0, 0.2), 60.0, 2.5),
        (DVec3::new(0.1, -3.0, 0.2), 60.0, 3.0),
        (DVec3::new(0.3, 0.2, -0.1), 40.0, 1e-4),
        (DVec3::new(0.3, 0.2, -0.1), 5.0, 0.5),
        (DVec3::new(0.0, -1.0, 0.0), 40.0, 1e-4),
        (DVec3::new(0.6, 0.0, 0.8), 40.0, 1e-3),
    ] {
        let camera = perspective(eye, focal, near);
        let oracle = Oracle::new(&scene, &camera);
        for (x, y) in grid(&camera, 3) {
            let mut expected = sphere_depths(&camera, x, y);
            let near_by = expected.iter().any(|z| (z / near - 1.0).abs() < 1e-4);
            expected.retain(|z| *z >= near);
            let mut found: Vec<f64> = oracle.hits(x, y).iter().map(|h| h.depth).collect();
            found.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            if !near_by {
                assert_eq!(
                    found.len(),
                    expected.len(),
                    "eye {eye}, ({x}, {y}): {found:?}, not {expected:?}; {:?}",
                    oracle.hits(x, y)
                );
                assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-8));
            }
        }
    }
}

#[test]
fn far_from_the_origin() {
    let eye = DVec3::new(3.0, -8.0, 2.0);
    let hits = |offset: DVec3, moved: bool| {
        let mut scene = shapes::scene(&shapes::torus(2.0, 0.5), offset);
        if moved {
            scene.instances[0].transform.translation = -offset;
        }
        let camera = perspective(eye + if moved { DVec3::ZERO } else { offset }, 150.0, 0.1);
        let oracle = Oracle::new(&scene, &camera);
        grid(&camera, 4).map(|(x, y)| oracle.hits(x, y)).collect::<Vec<_>>()
    };
    let reference = hits(DVec3::ZERO, false);
    assert!(reference.iter().flatten().count() > 100);
    for scale in [2.0_f64.powi(20), 2.0_f64.powi(30)] {
        // Powers of two, and origins that fit: the patches stand exactly where they stood.
        let offset = DVec3::new(scale, -scale, scale);
        for moved in [false, true] {
            for (a, b) in hits(offset, moved).iter().flatten().zip(reference.iter().flatten()) {
                assert_eq!(a.patch, b.patch);
                // Origins (radii of the torus) are integers and halves.
                assert!((a.depth - b.depth).abs() < 1e-9, "{a:?}, not {b:?}");
            }
        }
    }
}

/// All rays of a grid; every hit must be finite and in the patch.
fn survey(scene: &Scene, camera: &Camera) -> usize {
    let oracle = Oracle::new(scene, camera);
    let mut count = 0;
    for (x, y) in grid(camera, 5).chain(grid(camera, 5).map(|(x, y)| (x.floor() + 0.5, y.floor() + 0.5))) {
        for hit in oracle.hits(x, y) {
            let inside = (0.0..=1.0).contains(&hit.u) && (0.0..=1.0).contains(&hit.v);
            assert!(inside && hit.depth >= camera.near && hit.depth.is_finite(), "{hit:?}");
            count += 1;
        }
    }
    count
}

fn survey_part(degree: [usize; 2], point: impl Fn(f64, f64) -> DVec4, camera: &Camera) -> usize {
    let [m, n] = degree;
    let points = (0..=m).flat_map(|i| (0..=n).map(move |j| (i as f64 / m as f64, j as f64 / n as f64)));
    let part = Part::new(degree, points.map(|(u, v)| point(u, v)).collect(), 0);
    survey(&shapes::scene(&[part], DVec3::ZERO), camera)
}

#[test]
fn patches_without_area() {
    let camera = shapes::front([100, 100], 10.0);
    // A point at pixel (50, 50) is between all rays but (50.5, 50.5)'s neighbours.
    assert_eq!(survey_part([3, 3], |_, _| DVec4::W, &camera), 0);
    assert!(survey_part([3, 3], |_, _| DVec3::new(0.05, 0.0, -0.05).extend(1.0), &camera) > 0);
    // A line, drawn out of both parameters.
    assert!(survey_part([2, 2], |u, v| DVec3::new(4.0 * (u - v), 0.0, -0.05).extend(1.0), &camera) > 10);
    // Edge-on: along one parameter, and along neither.
    assert!(survey_part([1, 1], |u, v| DVec3::new(9.0 * u - 4.5, v, -0.05).extend(1.0), &camera) > 10);
    let across = |u: f64, v: f64| DVec3::new(4.0 * (u + v - 1.0), u - v, -0.05).extend(1.0);
    assert!(survey_part([3, 3], across, &camera) > 10);
    // Edge-on and bent.
    survey_part([3, 3], |u, v| DVec3::new(9.0 * u - 4.5, v, u * u - v * 0.0).extend(1.0), &camera);
    // All of it one line in space, the weights differ.
    survey_part([2, 2], |u, v| (DVec3::new(u * v, 0.0, u * v) * (1.0 + u)).extend(1.0 + u), &camera);
}

#[test]
fn collapsed_edges_huge_patches_wild_weights_and_degrees() {
    let camera = shapes::front([100, 100], 10.0);
    let tip = |u: f64, v: f64| DVec3::new(u * (v - 0.5) * 8.0, u, u * 4.0 - 2.05).extend(1.0);
    assert!(survey_part([2, 3], tip, &camera) > 10);
    for size in [1e6, 1e12] {
        let sheet = |u: f64, v: f64| DVec3::new((u - 0.4) * size, 1.0 + u * v, (v - 0.6) * size).extend(1.0);
        assert_eq!(survey_part([3, 3], sheet, &camera), 800, "size {size}");
        let near = perspective(DVec3::new(0.0, -1.0, 0.0), 50.0, 1e-4);
        assert_eq!(survey_part([3, 3], sheet, &near), 800);
    }
    let mut random = Random(9);
    for degree in [[25, 25], [25, 1], [1, 40], [7, 9]] {
        for spread in [1.0, 1000.0] {
            let part = shapes::random_patch(&mut random, degree, 0.02, spread);
            let scene = shapes::scene(&[part], DVec3::ZERO);
            assert!(survey(&scene, &shapes::camera(&scene, [60, 60], false)) > 20);
            survey(&scene, &perspective(DVec3::new(0.5, 0.5, 0.0), 50.0, 1e-4));
        }
    }
    survey_part([3, 3], |u, v| DVec3::new(u * 1e300, v * 1e300, 1.0).extend(1.0), &camera);
    survey_part([3, 3], |u, v| DVec3::new(u * 1e300, v * -1e300, 1.0).extend(1e-3), &camera);
}
