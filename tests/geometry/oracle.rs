//! Evaluation against `curvo`, an independent NURBS library.

use crate::nurbs::knots;
use crate::support::Random;
use curvo::prelude::{NurbsCurve3D, NurbsSurface3D};
use glam::DVec3;
use halfpixel::geometry::{NurbsCurve, NurbsSurface};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn surfaces_agree(seed: u64, p in 1usize..6, q in 1usize..6, a in 0usize..8, b in 0usize..8) {
        let mut random = Random(seed);
        let counts = [p + 1 + a, q + 1 + b];
        let [ku, kv] = [knots(&mut random, p, counts[0], true), knots(&mut random, q, counts[1], true)];
        let points = random.points(counts[0] * counts[1], 3.0);
        let rows = points.chunks_exact(counts[1]).map(|row| row.iter().map(|p| p.to_array().into()).collect()).collect();
        let theirs = NurbsSurface3D::<f64>::new(p, q, ku.clone(), kv.clone(), rows);
        let ours = NurbsSurface::new("random", [p, q], counts, [ku, kv], points).expect("good");
        for _ in 0..5 {
            let [u, v] = ours.domain().map(|[low, high]| random.between(low, high));
            let at = ours.surface_point(u, v);
            let derivatives = theirs.rational_derivatives(u, v, 1);
            let vector = |i: usize, j: usize| DVec3::from_array(derivatives[i][j].into());
            let scale = 1.0 + at.du.length() + at.dv.length();
            prop_assert!((at.position - vector(0, 0)).length() < 1e-12, "{} {}", at.position, vector(0, 0));
            prop_assert!((at.du - vector(1, 0)).length() < 1e-11 * scale, "{} {}", at.du, vector(1, 0));
            prop_assert!((at.dv - vector(0, 1)).length() < 1e-11 * scale, "{} {}", at.dv, vector(0, 1));
        }
    }

    #[test]
    fn curves_agree(seed: u64, p in 1usize..8, more in 0usize..8) {
        let mut random = Random(seed);
        let count = p + 1 + more;
        let knots = knots(&mut random, p, count, true);
        let points = random.points(count, 3.0);
        let theirs = points.iter().map(|p| p.to_array().into()).collect();
        let theirs = NurbsCurve3D::<f64>::try_new(p, theirs, knots.clone());
        prop_assume!(theirs.is_ok());
        let ours = NurbsCurve::new("random", p, knots, points).expect("good");
        for _ in 0..5 {
            let t = random.between(ours.domain()[0], ours.domain()[1]);
            let theirs: DVec3 = <[f64; 3]>::from(theirs.as_ref().expect("checked").point_at(t).coords).into();
            prop_assert!((ours.position(t) - theirs).length() < 1e-12);
        }
    }
}
