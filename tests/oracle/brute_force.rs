//! Random rational patches: what plain subdivision finds, the oracle finds, and nothing else.

use crate::shapes::{self, Random};
use glam::{DVec2, DVec3};
use halfpixel::geometry::BezierPatch;
use halfpixel::scene::{Camera, Scene};
use halfpixel::verify::Oracle;

/// Sizes of what plain subdivision ends with, in pixels.
const SIZE: f64 = 1e-5;

/// Parameters where the hull of a tiny part holds the image point.
fn candidates(scene: &Scene, camera: &Camera, p: DVec2) -> Vec<DVec2> {
    let source = &scene.patches[0];
    let mut stack: Vec<(BezierPatch, DVec2, DVec2)> = vec![(scene.net(source).to_patch(), DVec2::ZERO, DVec2::ONE)];
    let mut found = Vec::new();
    while let Some((patch, low, high)) = stack.pop() {
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for at in patch.net().hull() {
            let pixel = shapes::project(camera, at + source.origin);
            (least, most) = (least.min(pixel), most.max(pixel));
        }
        if least.cmpgt(p).any() || most.cmplt(p).any() {
            continue;
        }
        let middle = (low + high) * 0.5;
        if (most - least).max_element() < SIZE {
            found.push(middle);
            continue;
        }
        for (i, half) in patch.net().split(0, 0.5).into_iter().enumerate() {
            for (j, quarter) in half.net().split(1, 0.5).into_iter().enumerate() {
                let pick = |first: bool, axis: usize| {
                    if first { (low[axis], middle[axis]) } else { (middle[axis], high[axis]) }
                };
                let ((u0, u1), (v0, v1)) = (pick(i == 0, 0), pick(j == 0, 1));
                stack.push((quarter, DVec2::new(u0, v0), DVec2::new(u1, v1)));
            }
        }
    }
    found
}

fn compare(degree: [usize; 2], spread: f64, patches: u64, rays: usize) {
    let mut hits_seen = 0;
    for seed in 0..patches {
        let mut random = Random(seed * 77 + degree[0] as u64);
        let part = shapes::random_patch(&mut random, degree, 0.5, spread);
        let scene = shapes::scene(&[part], DVec3::ZERO);
        let camera = shapes::camera(&scene, [96, 96], seed % 2 == 1);
        let oracle = Oracle::new(&scene, &camera);
        for _ in 0..rays {
            let p = DVec2::new(20.0 + 56.0 * random.unit(), 20.0 + 56.0 * random.unit());
            let hits = oracle.hits(p.x, p.y);
            hits_seen += hits.len();
            for hit in &hits {
                let source = &scene.patches[0];
                let at = scene.net(source).position(hit.u, hit.v) + source.origin;
                let off = (shapes::project(&camera, at) - p).abs().max_element();
                assert!(off < if hit.certified { 1e-4 } else { 3e-4 }, "seed {seed}: {off} px off: {hit:?}");
            }
            for found in candidates(&scene, &camera, p) {
                let near = |h: &halfpixel::verify::Hit| (DVec2::new(h.u, h.v) - found).abs().max_element() < 1e-2;
                assert!(hits.iter().any(near), "seed {seed}, {p}: no hit at {found}, only {hits:?}");
            }
        }
    }
    assert!(hits_seen > 50, "{hits_seen} hits");
}

#[test]
fn bicubic() {
    compare([3, 3], 3.0, 12, 60);
}

#[test]
fn other_degrees_and_wild_weights() {
    compare([2, 5], 10.0, 6, 30);
    compare([1, 4], 1.0, 6, 30);
    compare([3, 2], 1000.0, 6, 30);
}
