//! Spheres, tori, cylinders and planes have closed forms.

use crate::shapes::{self, Part, Random};
use glam::DVec3;
use halfpixel::scene::{Camera, Scene};
use halfpixel::verify::Oracle;

/// Real roots of a polynomial (lowest power first) in [low, high], ascending; double roots may be missed or found.
fn roots(polynomial: &[f64], low: f64, high: f64) -> Vec<f64> {
    if polynomial.len() < 2 {
        return Vec::new();
    }
    let derivative: Vec<f64> = (1..polynomial.len()).map(|k| polynomial[k] * k as f64).collect();
    let value = |t: f64| polynomial.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let mut ends = vec![low];
    ends.extend(roots(&derivative, low, high));
    ends.push(high);
    let mut found = Vec::new();
    for pair in ends.windows(2) {
        let (mut a, mut b) = (pair[0], pair[1]);
        if value(a) * value(b) > 0.0 {
            continue;
        }
        let rising = value(b) > value(a);
        for _ in 0..200 {
            let middle = 0.5 * (a + b);
            if (value(middle) > 0.0) == rising {
                b = middle;
            } else {
                a = middle;
            }
        }
        found.push(0.5 * (a + b));
    }
    found
}

/// Depths of the hits; shared borders counted once.
fn depths(oracle: &Oracle, x: f64, y: f64) -> Vec<f64> {
    let mut depths: Vec<f64> = oracle.hits(x, y).iter().map(|h| h.depth).collect();
    depths.dedup_by(|b, a| (*b - *a).abs() < 1e-6 * a.abs());
    depths
}

/// Compares with the roots in z of a polynomial along the ray. Rays whose roots change within 2 resolutions of the image
/// point are tangential: there it must only not fail.
fn compare(scene: &Scene, camera: &Camera, rays: usize, seed: u64, implicit: impl Fn(DVec3, DVec3) -> Vec<f64>) {
    let oracle = Oracle::new(scene, camera);
    let mut random = Random(seed);
    let expected = |x: f64, y: f64| {
        let (origin, step) = shapes::ray(camera, x, y);
        roots(&implicit(origin, step), camera.near, camera.near + camera.extent)
    };
    let (mut met, mut tangential) = (0, 0);
    for _ in 0..rays {
        let (x, y) = (random.unit() * f64::from(camera.size[0]), random.unit() * f64::from(camera.size[1]));
        let exact = expected(x, y);
        let d = 2e-4;
        if [(d, 0.0), (-d, 0.0), (0.0, d), (0.0, -d)].iter().any(|o| expected(x + o.0, y + o.1).len() != exact.len()) {
            oracle.hits(x, y);
            tangential += 1;
            continue;
        }
        let found = depths(&oracle, x, y);
        assert_eq!(found.len(), exact.len(), "at ({x}, {y}): {found:?}, not {exact:?}; {:?}", oracle.hits(x, y));
        met += usize::from(!exact.is_empty());
        for (a, b) in found.iter().zip(&exact) {
            assert!((a - b).abs() < 1e-8 * b, "at ({x}, {y}): {a}, not {b}");
        }
    }
    assert!(met * 10 > rays && tangential * 20 < rays, "{met} met, {tangential} tangential of {rays}");
}

fn both_projections(parts: &[Part], rays: usize, implicit: impl Fn(DVec3, DVec3) -> Vec<f64>) {
    let scene = shapes::scene(parts, DVec3::ZERO);
    for orthographic in [false, true] {
        let camera = shapes::camera(&scene, [300, 200], orthographic);
        compare(&scene, &camera, rays, 11, &implicit);
    }
}

/// (o + t d)² summed over the given axes, as a polynomial in t.
fn square(o: DVec3, d: DVec3, axes: &[usize]) -> [f64; 3] {
    axes.iter().fold([0.0; 3], |[a, b, c], &k| [a + o[k] * o[k], b + 2.0 * o[k] * d[k], c + d[k] * d[k]])
}

#[test]
fn sphere() {
    both_projections(&shapes::sphere(1.5), 5000, |o, d| {
        let [a, b, c] = square(o, d, &[0, 1, 2]);
        vec![a - 2.25, b, c]
    });
}

#[test]
fn torus() {
    both_projections(&shapes::torus(2.0, 0.75), 5000, |o, d| {
        // (|p|² + R² - r²)² = 4 R² (x² + y²)
        let [mut a, b, c] = square(o, d, &[0, 1, 2]);
        a += 4.0 - 0.5625;
        let [e, f, g] = square(o, d, &[0, 1]).map(|k| 16.0 * k);
        vec![a * a - e, 2.0 * a * b - f, b * b + 2.0 * a * c - g, 2.0 * b * c, c * c]
    });
}

#[test]
fn cylinder_is_open_at_its_ends() {
    let scene = shapes::scene(&shapes::cylinder(), DVec3::ZERO);
    let camera = shapes::camera(&scene, [300, 200], false);
    let oracle = Oracle::new(&scene, &camera);
    let mut random = Random(5);
    for _ in 0..5000 {
        let (x, y) = (random.unit() * 300.0, random.unit() * 200.0);
        let (o, d) = shapes::ray(&camera, x, y);
        let [a, b, c] = square(o, d, &[0, 1]);
        let all = roots(&[a - 1.0, b, c], 0.0, 1e3);
        let heights: Vec<f64> = all.iter().map(|t| (o + d * *t).z.abs()).collect();
        if (a - b * b / (4.0 * c) - 1.0).abs() < 1e-3 || heights.iter().any(|h| (h - 1.0).abs() < 1e-3) {
            continue;
        }
        let expected: Vec<f64> = all.into_iter().zip(heights).filter(|(_, h)| *h < 1.0).map(|(t, _)| t).collect();
        let found = depths(&oracle, x, y);
        assert_eq!(found.len(), expected.len(), "at ({x}, {y})");
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9 * b));
    }
}

#[test]
fn tangential_rays_end_at_the_resolution() {
    let scene = shapes::scene(&shapes::sphere(1.0), DVec3::ZERO);
    let camera = shapes::front([200, 200], 80.0);
    let oracle = Oracle::new(&scene, &camera);
    for i in 0..500 {
        let angle = f64::from(i) * 0.0123;
        let at = |radius: f64| (100.0 + radius * angle.cos(), 100.0 + radius * angle.sin());
        let (x, y) = at(80.0);
        assert!(!oracle.hits(x, y).is_empty(), "on the outline at {angle}");
        let (x, y) = at(80.0 - 1e-2);
        assert_eq!(depths(&oracle, x, y).len(), 2, "inside at {angle}");
        let (x, y) = at(80.0 + 2e-4);
        assert!(oracle.hits(x, y).is_empty(), "outside at {angle}");
    }
}

#[test]
fn shared_borders_are_closed() {
    for (parts, closed) in [(shapes::sphere(1.0), true), (shapes::torus(2.0, 0.5), true), (checkerboard(), false)] {
        let scene = shapes::scene(&parts, DVec3::ZERO);
        for orthographic in [false, true] {
            let camera = shapes::camera(&scene, [320, 240], orthographic);
            let oracle = Oracle::new(&scene, &camera);
            for (patch, i) in (0..scene.patches.len()).flat_map(|p| (0..=96).map(move |i| (p, i))) {
                let t = f64::from(i) / 96.0;
                for [u, v] in [[t, 0.0], [t, 1.0], [0.0, t], [1.0, t], [t, t]] {
                    let source = &scene.patches[patch];
                    let at = scene.net(source).surface_point(u, v);
                    let p = shapes::project(&camera, at.position + source.origin);
                    let hits = oracle.hits(p.x, p.y);
                    assert!(hits.iter().any(|h| h.patch as usize == patch), "patch {patch} at {u} {v}");
                    // A ray that enters a closed surface leaves it.
                    let facing =
                        at.du.cross(at.dv).normalize_or_zero().dot(shapes::ray(&camera, p.x, p.y).1.normalize());
                    assert!(!closed || facing.abs() < 1e-2 || depths(&oracle, p.x, p.y).len() >= 2, "{hits:?}");
                }
            }
        }
    }
}

/// 4x4 squares of a bumpy sheet that share their borders.
fn checkerboard() -> Vec<Part> {
    let height = |x: f64, y: f64| (3.0 * x).sin() * (2.0 * y).cos();
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f64 / 3.0, j as f64 / 3.0);
        DVec3::new(x, y, height(x, y)).extend(1.0)
    };
    let square = |a: usize, b: usize| (0..16).map(|k| point(3 * a + k / 4, 3 * b + k % 4)).collect();
    (0..16).map(|k| Part::new([3, 3], square(k / 4, k % 4), k as u32)).collect()
}
