//! `Net::jet` against de Casteljau in double-double, within the bound its documentation states.

use crate::support::{ROUNDOFF, Random, partial};
use halfpixel::geometry::MAX_DEGREE;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn jets_keep_their_error_bound(seed: u64, m in 1usize..12, n in 1usize..12, spread in 1.0..1e3) {
        check(seed, [m, n], spread);
    }

    #[test]
    fn normals_and_positions_divide_the_jet(seed: u64, m in 1usize..6, n in 1usize..6, spread in 1.0..10.0) {
        let mut random = Random(seed);
        let patch = random.patch([m, n], spread);
        let [u, v] = [random.between(0.1, 0.9), random.between(0.1, 0.9)];
        let at = patch.net().surface_point(u, v);
        prop_assert!((at.position - patch.net().position(u, v)).length() < 1e-15);
        // Central differences: truncation h² and cancellation 1e-16 / h.
        let h = 1e-5;
        let [du, dv] = [[h, 0.0], [0.0, h]].map(|[a, b]| {
            (patch.net().position(u + a, v + b) - patch.net().position(u - a, v - b)) / (2.0 * h)
        });
        let scale = spread.powi(6) * (m * n) as f64;
        prop_assert!((at.du - du).length() < 1e-7 * scale, "{} {du}", at.du);
        prop_assert!((at.dv - dv).length() < 1e-7 * scale, "{} {dv}", at.dv);
    }
}

#[test]
fn jets_of_the_highest_degree_keep_their_error_bound() {
    for seed in 0..3 {
        check(seed, [MAX_DEGREE, MAX_DEGREE], 10.0);
        check(seed, [MAX_DEGREE, 1], 10.0);
    }
}

fn check(seed: u64, [m, n]: [usize; 2], spread: f64) {
    let mut random = Random(seed);
    let patch = random.patch([m, n], spread);
    // The corners too: they must be exact.
    let inner = [random.unit(), random.unit()];
    for [u, v] in [inner, [0.0, 1.0], [1.0, 0.0], [inner[0], 1.0]] {
        let jet = patch.net().jet(u, v);
        for axis in 0..4 {
            let largest = patch.points().iter().map(|p| p[axis].abs()).fold(0.0, f64::max);
            let levels = (m + n) as f64;
            let point = 3.0 * levels * ROUNDOFF * largest;
            let derivative = |degree: usize| 2.0 * degree as f64 * (3.0 * levels + 2.0) * ROUNDOFF * largest;
            let cases = [
                ([0, 0], jet.point[axis], point),
                ([1, 0], jet.du[axis], derivative(m)),
                ([0, 1], jet.dv[axis], derivative(n)),
            ];
            for (orders, found, bound) in cases {
                let exact = partial(&patch, axis, orders, u, v).value();
                let error = (found - exact).abs();
                assert!(error <= bound * (1.0 + 1e-10), "{orders:?} ({u}, {v}): {error:e} > {bound:e}");
            }
        }
        if [u, v] == [0.0, 1.0] {
            assert_eq!(jet.point, patch.net().point(0, n));
        }
    }
}
