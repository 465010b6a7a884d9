//! What a full check costs: `cargo test --release --test oracle cost -- --ignored --nocapture`.

use crate::frames::Picture;
use crate::shapes::{self, Part};
use glam::DVec3;
use halfpixel::scene::ViewSpec;
use halfpixel::verify::{Oracle, Sampling};
use std::f64::consts::PI;
use std::time::Instant;

/// A bumpy ball of `2 n * n` bicubic patches.
fn ball(n: usize) -> Vec<Part> {
    let surface = |a: f64, b: f64| {
        let (u, v) = (a / n as f64 * PI, b / n as f64 * PI);
        let r = 1.0 + 0.05 * (9.0 * u).sin() * (11.0 * v).cos() * v.sin();
        DVec3::new(v.sin() * u.cos(), v.sin() * u.sin(), -v.cos()) * r
    };
    // Cubic through four points a direction: C0 is enough.
    let weights = [
        [1.0, 0.0, 0.0, 0.0],
        [-5.0 / 6.0, 3.0, -1.5, 1.0 / 3.0],
        [1.0 / 3.0, -1.5, 3.0, -5.0 / 6.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let patch = |a: usize, b: usize| {
        let mut points = Vec::new();
        for row in weights {
            for column in weights {
                let mut p = DVec3::ZERO;
                for (i, wi) in row.iter().enumerate() {
                    for (j, wj) in column.iter().enumerate() {
                        p += surface(a as f64 + i as f64 / 3.0, b as f64 + j as f64 / 3.0) * (wi * wj);
                    }
                }
                points.push(p.extend(1.0));
            }
        }
        Part::new([3, 3], points, 0)
    };
    (0..2 * n).flat_map(|a| (0..n).map(move |b| (a, b))).map(|(a, b)| patch(a, b)).collect()
}

#[test]
#[ignore = "a measurement"]
fn full_hd() {
    for (n, zoom) in [(76, 0.95), (6, 0.95), (76, 8.0)] {
        let scene = shapes::scene(&ball(n), DVec3::ZERO);
        let camera = ViewSpec { size: [1920, 1080], zoom, ..ViewSpec::default() }.camera(&scene.bounds).unwrap();
        let start = Instant::now();
        drop(Oracle::new(&scene, &camera));
        let built = start.elapsed().as_secs_f64();
        let picture = Picture::perfect(scene, camera);
        let report = picture.verify(Sampling::default());
        println!(
            "{} patches, zoom {zoom}: {built:.2} s to build, {:.2} s for {} pixels, {} drawn; {:?} {:?}",
            picture.scene.patches.len(),
            report.seconds,
            report.pixels,
            report.drawn,
            report.refined_error_px,
            report.worst,
        );
        assert!(report.passed());
    }
}
