//! The nets of second derivatives hold them.

use crate::support::{Random, partial};
use glam::DVec3;
use halfpixel::geometry::BezierPatch;
use halfpixel::geometry::bernstein::second_derivatives as derivative_patches;
use proptest::prelude::*;

/// `S_uu`, `S_uv`, `S_vv` at (u, v) by the quotient rule on homogeneous derivatives, these in double-double.
fn second_derivatives(patch: &BezierPatch, u: f64, v: f64) -> [DVec3; 3] {
    let space = |i, j| DVec3::from_array([0, 1, 2].map(|axis| partial(patch, axis, [i, j], u, v).value()));
    let weight = |i, j| partial(patch, 3, [i, j], u, v).value();
    let w = weight(0, 0);
    let s = space(0, 0) / w;
    let su = (space(1, 0) - s * weight(1, 0)) / w;
    let sv = (space(0, 1) - s * weight(0, 1)) / w;
    [
        (space(2, 0) - su * (2.0 * weight(1, 0)) - s * weight(2, 0)) / w,
        (space(1, 1) - su * weight(0, 1) - sv * weight(1, 0) - s * weight(1, 1)) / w,
        (space(0, 2) - sv * (2.0 * weight(0, 1)) - s * weight(0, 2)) / w,
    ]
}

/// Control points of `S_uu`, `S_uv`, `S_vv`.
fn second_derivative_sets(patch: &BezierPatch) -> [Vec<DVec3>; 3] {
    derivative_patches(patch.net()).map(|derivative| derivative.net().hull().collect())
}

/// Every value within the hull: along axes, diagonals and random directions; a corner's value is in the set itself.
fn check(patch: &BezierPatch, random: &mut Random) {
    let sets = second_derivative_sets(patch);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let directions: Vec<DVec3> = axes.into_iter().chain((0..6).map(|_| random.vector())).collect();
    let spans: Vec<Vec<[f64; 2]>> = sets.iter().map(|set| directions.iter().map(|&d| span(set, d)).collect()).collect();
    let radii = sets.each_ref().map(|set| set.iter().map(|p| p.length()).fold(0.0, f64::max));
    for k in 0..6 {
        let [u, v] = if k == 0 { [0.0, 0.0] } else { [random.unit(), random.unit()] };
        for (which, value) in second_derivatives(patch, u, v).into_iter().enumerate() {
            // Rounding of the sets: relative to them, with an allowance for what cancelled.
            let slack = 1e-11 * radii[which] + 1e-13;
            for (d, [low, high]) in directions.iter().zip(&spans[which]) {
                let x = value.dot(*d);
                assert!(low - slack <= x && x <= high + slack, "{which} ({u}, {v}): {x} outside [{low}, {high}]");
            }
            if k == 0 {
                let error = (sets[which][0] - value).length();
                assert!(error <= slack, "{which}: corner {} is not {value}, off by {error:e}", sets[which][0]);
            }
        }
    }
}

fn span(set: &[DVec3], direction: DVec3) -> [f64; 2] {
    let dots = set.iter().map(|p| p.dot(direction));
    dots.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn hold_rational_patches(seed: u64, m in 1usize..6, n in 1usize..6, spread in 1.0..10.0) {
        let mut random = Random(seed);
        check(&random.patch([m, n], spread), &mut random);
    }

    #[test]
    fn hold_polynomial_patches(seed: u64, m in 1usize..6, n in 1usize..6, weight in 0.01..100.0) {
        let mut random = Random(seed);
        let mut patch = random.patch([m, n], 1.0);
        patch.points_mut().iter_mut().for_each(|p| *p *= weight);
        check(&patch, &mut random);
    }
}

#[test]
fn hold_patches_of_high_degree() {
    for degree in [[13, 2], [1, 22], [25, 25]] {
        let mut random = Random(degree[0] as u64);
        check(&random.patch(degree, 1.5), &mut random);
    }
}

#[test]
fn far_from_the_origin_the_sets_stay_the_same() {
    let mut random = Random(7);
    let near = random.patch([3, 2], 4.0);
    let mut far = near.clone();
    far.points_mut().iter_mut().for_each(|p| *p += (DVec3::splat(1048576.0) * p.w).extend(0.0));
    let [near, far] = [near, far].map(|patch| second_derivative_sets(&patch));
    for (a, b) in near.iter().flatten().zip(far.iter().flatten()) {
        // The coordinates themselves were rounded to 1e-10 by the move; weights' ratio 16, degree² 9.
        assert!((*a - *b).length() < 1e-10 * 16f64.powi(3) * 9.0, "{a} {b}");
    }
}

#[test]
fn bound_a_quarter_cylinder_within_twice_the_truth() {
    use halfpixel::geometry::exact::{Frame, cylinder};
    let pieces = cylinder(&Frame::IDENTITY, 1.0, [[0.0, std::f64::consts::FRAC_PI_2], [0.0, 1.0]]);
    let patch = &pieces[0].patch;
    let [uu, uv, vv] = second_derivative_sets(patch).map(|s| s.iter().map(|p| p.length()).fold(0.0, f64::max));
    let truth = (0..=100).map(|k| second_derivatives(patch, k as f64 / 100.0, 0.5)[0].length()).fold(0.0, f64::max);
    assert!((truth..2.0 * truth).contains(&uu), "{uu} {truth}");
    assert!(uv < 1e-14 && vv < 1e-14, "{uv} {vv}");
}
