//! Refinement: the same bits at every SIMD level, and the same point as an f64 iteration.

use super::Random;
use crate::geometry::Net;
use crate::stages::newton::{Batch, LANES, Surface, refine};
use fearless_simd::{Level, dispatch};
use glam::{DVec4, Vec4};

/// A net some 200 pixels wide about the origin, with weights where `rational`.
fn net(random: &mut Random, [m, n]: [usize; 2], rational: bool) -> Vec<Vec4> {
    let mut points = Vec::new();
    for i in 0..=m {
        for j in 0..=n {
            let w = if rational { random.between(0.5, 2.0) } else { 1.0 };
            let at = |k: usize, d: usize| (k as f64 / d as f64 - 0.5) * 200.0;
            let (x, y) = (at(i, m) + random.between(-9.0, 9.0), at(j, n) + random.between(-9.0, 9.0));
            // In perspective the denominator is Z + 10 w.
            let z = random.between(-0.5, 0.5);
            points.push(DVec4::new(x * (z + 10.0), y * (z + 10.0), z, 1.0).as_vec4() * w as f32);
        }
    }
    points
}

fn surface<'a>(net: &'a [Vec4], degree: [usize; 2], rational: bool) -> Surface<'a> {
    Surface {
        net,
        degree,
        rational,
        perspective: true,
        depth_origin: 10.0,
        rounding: 2e-4,
        domain: [[0.0, 1.0]; 2],
        depth_tolerance: 1.0,
        any_sheet: false,
    }
}

fn pixels(random: &mut Random) -> Batch {
    let mut batch = Batch::default();
    for k in 0..LANES {
        let (s, t) = (random.between(0.1, 0.9), random.between(0.1, 0.9));
        (batch.s[k], batch.t[k]) = (s as f32, t as f32);
        // Within some pixels of where a flat patch would have them.
        batch.x[k] = ((s - 0.5) * 200.0 + random.between(-6.0, 6.0)) as f32;
        batch.y[k] = ((t - 0.5) * 200.0 + random.between(-6.0, 6.0)) as f32;
    }
    batch
}

fn bits(batch: &Batch) -> Vec<u32> {
    let normal = batch.normal.as_flattened();
    let all = [&batch.s[..], &batch.t[..], &batch.residual[..], &batch.z[..], normal];
    all.concat().iter().map(|v| v.to_bits()).collect()
}

const DEGREES: [[usize; 2]; 7] = [[1, 1], [2, 1], [3, 3], [2, 3], [5, 4], [7, 7], [9, 2]];

#[test]
fn every_simd_level_gives_the_same_bits() {
    let mut random = Random(7);
    let level = Level::new();
    for k in 0..700 {
        let (degree, rational) = (DEGREES[k % DEGREES.len()], k % 2 == 0);
        let net = net(&mut random, degree, rational);
        let surface = surface(&net, degree, rational);
        let start = pixels(&mut random);
        let mut best = start;
        dispatch!(level, simd => refine(simd, &surface, 2, &mut best));
        #[cfg(target_arch = "x86_64")]
        {
            let compare = |name: &str, run: &mut dyn FnMut(&mut Batch)| {
                let mut other = start;
                run(&mut other);
                assert_eq!(bits(&best), bits(&other), "{name}, degree {degree:?}");
            };
            if let Some(simd) = level.as_sse2() {
                compare("sse2", &mut |b| refine(simd, &surface, 2, b));
            }
            if let Some(simd) = level.as_sse4_2() {
                compare("sse4.2", &mut |b| refine(simd, &surface, 2, b));
            }
            if let Some(simd) = level.as_avx2() {
                compare("avx2", &mut |b| refine(simd, &surface, 2, b));
            }
        }
    }
}

#[test]
fn what_refinement_reports_is_the_surface_there() {
    let mut random = Random(8);
    let level = Level::new();
    let mut reached = 0;
    for k in 0..700 {
        let (degree, rational) = (DEGREES[k % DEGREES.len()], k % 2 == 0);
        let net = net(&mut random, degree, rational);
        let surface = surface(&net, degree, rational);
        let mut batch = pixels(&mut random);
        dispatch!(level, simd => refine(simd, &surface, 2, &mut batch));
        let exact: Vec<DVec4> = net.iter().map(|p| p.as_dvec4()).collect();
        for k in 0..LANES {
            // The same parameter by de Casteljau in f64, which shares no code with the lanes.
            let p = Net::new(degree, &exact).jet(f64::from(batch.s[k]), f64::from(batch.t[k])).point;
            let d = p.z + 10.0 * p.w;
            let off = (p.x / d - f64::from(batch.x[k])).abs().max((p.y / d - f64::from(batch.y[k])).abs());
            assert!((off - f64::from(batch.residual[k])).abs() < 2e-3, "{off} {} {degree:?}", batch.residual[k]);
            reached += usize::from(off < 1.0 / 256.0);
        }
    }
    // Most centres lie on the patch; the rest are past its border.
    assert!(reached > 700 * LANES * 9 / 10, "{reached}");
}

/// On the fold itself derivatives say nothing of how far to go, and next to it next to nothing.
#[test]
fn refinement_leaves_a_fold_it_starts_on() {
    let mut random = Random(9);
    let level = Level::new();
    // x = 301 + 9 (2 s - 1)^2, y = 200 (t - 1/2), z = s - 1/2: far enough out for rounding to be seen.
    let place =
        |i: usize, j: usize| (if i == 1 { 292.0 } else { 310.0 }, (j as f64 - 0.5) * 200.0, (i as f64 - 1.0) * 0.5);
    let corner = |(x, y, z): (f64, f64, f64)| DVec4::new(x * (z + 10.0), y * (z + 10.0), z, 1.0);
    let points: Vec<DVec4> = (0..6).map(|k| corner(place(k / 2, k % 2))).collect();
    let raised = Net::new([2, 1], &points).elevate([3, 3]);
    let net: Vec<Vec4> = raised.points().iter().map(|p| p.as_vec4()).collect();
    let surface = surface(&net, [3, 3], false);
    for _ in 0..2000 {
        let mut batch = Batch::default();
        for k in 0..LANES {
            let beside = random.between(-1.0, 1.0) * 10f64.powf(random.between(-8.0, -4.0));
            batch.s[k] = (0.5 + beside) as f32;
            batch.t[k] = random.between(0.2, 0.8) as f32;
            batch.x[k] = 301.0 + 10f64.powf(random.between(-2.0, 0.5)) as f32;
            batch.y[k] = (batch.t[k] - 0.5) * 200.0 + random.between(-0.2, 0.2) as f32;
        }
        dispatch!(level, simd => refine(simd, &surface, 2, &mut batch));
        assert!(batch.residual.iter().all(|&r| r < 1.0 / 256.0), "{batch:?}");
    }
}
