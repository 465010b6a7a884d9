//! B-splines against their Bézier pieces; knot insertion, elevation and restriction change nothing.

use crate::support::Random;
use glam::{DVec3, DVec4};
use halfpixel::geometry::{NurbsCurve, NurbsSurface};
use proptest::prelude::*;

/// `count + degree + 1` knots from -1 up: runs of equal knots up to degree + 2 long, clamped or not.
pub fn knots(random: &mut Random, degree: usize, count: usize, clamped: bool) -> Vec<f64> {
    let mut knots = vec![-1.0];
    while knots.len() < count + degree + 1 {
        let step = if random.below(3) == 0 { 0.0 } else { random.between(0.05, 1.0) };
        knots.push(knots[knots.len() - 1] + step);
    }
    if clamped {
        let [first, last] = [knots[degree], knots[count]];
        knots[..degree].fill(first);
        knots[count + 1..].fill(last);
    }
    if knots[degree] == knots[count] {
        knots[count..].iter_mut().for_each(|t| *t += 1.0);
    }
    knots
}

fn surface(random: &mut Random, degree: [usize; 2], more: [usize; 2], clamped: bool) -> NurbsSurface {
    let counts = [0, 1].map(|axis| degree[axis] + 1 + more[axis]);
    let knots = [0, 1].map(|axis| knots(random, degree[axis], counts[axis], clamped));
    let points = random.points(counts[0] * counts[1], 4.0);
    NurbsSurface::new("random", degree, counts, knots, points).expect("a good surface")
}

/// A parameter inside the domain, sometimes a knot.
fn parameter(random: &mut Random, knots: &[f64], [low, high]: [f64; 2]) -> f64 {
    let knot = knots[random.below(knots.len())];
    if random.below(4) == 0 { knot.clamp(low, high) } else { random.between(low, high) }
}

fn close(a: DVec4, b: DVec4, scale: f64) -> Result<(), TestCaseError> {
    prop_assert!((a - b).length() <= 1e-13 * scale, "{a} {b}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn pieces_are_the_surface(seed: u64, p in 1usize..6, q in 1usize..6, a in 0usize..8, b in 0usize..8, clamped: bool) {
        let mut random = Random(seed);
        let surface = surface(&mut random, [p, q], [a, b], clamped);
        for piece in surface.bezier_pieces() {
            let [s, t] = [random.unit(), random.unit()];
            let at = |axis: usize, s: f64| piece.domain[axis][0] + (piece.domain[axis][1] - piece.domain[axis][0]) * s;
            let [width, height] = [0, 1].map(|axis| piece.domain[axis][1] - piece.domain[axis][0]);
            let [whole, part] = [surface.jet(at(0, s), at(1, t)), piece.patch.net().jet(s, t)];
            close(whole.point, part.point, 10.0)?;
            // Short spans make steep derivatives; on the piece's own scale both are of the size of the net.
            close(whole.du * width, part.du, 100.0)?;
            close(whole.dv * height, part.dv, 100.0)?;
        }
    }

    #[test]
    fn neighbours_share_their_border(seed: u64, p in 1usize..5, q in 1usize..5) {
        let mut random = Random(seed);
        let counts = [p + 4, q + 4];
        let uniform = |degree: usize, count: usize| (0..count + degree + 1).map(|k| (k as f64).sqrt()).collect();
        let knots = [uniform(p, counts[0]), uniform(q, counts[1])];
        let points = random.points(counts[0] * counts[1], 4.0);
        let pieces = NurbsSurface::new("smooth", [p, q], counts, knots, points).expect("good").bezier_pieces();
        prop_assert_eq!(pieces.len(), 16);
        for (k, piece) in pieces.iter().enumerate() {
            let net = piece.patch.net();
            if k % 4 < 3 {
                let right = pieces[k + 1].patch.net();
                prop_assert!((0..=p).all(|i| net.point(i, q) == right.point(i, 0)));
            }
            if k < 12 {
                let below = pieces[k + 4].patch.net();
                prop_assert!((0..=q).all(|j| net.point(p, j) == below.point(0, j)));
            }
        }
    }

    #[test]
    fn inserted_knots_change_nothing(seed: u64, p in 1usize..6, q in 1usize..6, axis in 0usize..2, clamped: bool) {
        let mut random = Random(seed);
        let surface = surface(&mut random, [p, q], [4, 4], clamped);
        let knots = &surface.knots()[axis];
        let t = parameter(&mut random, knots.values(), knots.domain());
        let finer = surface.insert_knot(axis, t);
        let multiplicity = knots.values().iter().filter(|&&k| k == t).count();
        prop_assert_eq!(finer.points().len() > surface.points().len(), multiplicity <= knots.degree());
        prop_assert_eq!(finer.domain(), surface.domain());
        for _ in 0..10 {
            let [u, v] = surface.domain().map(|[low, high]| random.between(low, high));
            close(surface.jet(u, v).point, finer.jet(u, v).point, 10.0)?;
        }
    }

    #[test]
    fn inserted_knots_change_no_curve(seed: u64, p in 1usize..8, more in 0usize..8, clamped: bool) {
        let mut random = Random(seed);
        let count = p + 1 + more;
        let knots = knots(&mut random, p, count, clamped);
        let curve = NurbsCurve::new("random", p, knots, random.points(count, 4.0)).expect("good");
        let t = parameter(&mut random, curve.knots(), curve.domain());
        let finer = curve.insert_knot(t).insert_knot(t);
        for piece in curve.bezier_pieces() {
            let s = random.unit();
            let [low, high] = piece.domain;
            let whole = curve.jet(low + (high - low) * s);
            close(whole.0, piece.curve.jet(s).0, 10.0)?;
            close(whole.1 * (high - low), piece.curve.jet(s).1, 100.0)?;
            close(whole.0, finer.jet(low + (high - low) * s).0, 10.0)?;
        }
    }

    #[test]
    fn elevation_changes_nothing(seed: u64, m in 1usize..8, n in 1usize..8, more in 0usize..9, less in 0usize..9) {
        let mut random = Random(seed);
        let patch = random.patch([m, n], 4.0);
        let high = patch.net().elevate([m + more, n + less]);
        prop_assert_eq!(high.degree(), [m + more, n + less]);
        let [u, v] = [random.unit(), random.unit()];
        let [a, b] = [patch.net().jet(u, v), high.net().jet(u, v)];
        close(a.point, b.point, 10.0)?;
        close(a.du, b.du, 100.0)?;
        close(a.dv, b.dv, 100.0)?;
    }

    #[test]
    fn parts_are_the_whole(seed: u64, m in 1usize..8, n in 1usize..8, cuts in prop::array::uniform3(0.0..1.0)) {
        let mut random = Random(seed);
        let patch = random.patch([m, n], 4.0);
        let [mut low, mut high, v0] = cuts;
        if high < low { std::mem::swap(&mut low, &mut high) }
        let range = [[low, high], [v0, 1.0]];
        let part = patch.net().restrict(range);
        let next = patch.net().restrict([[high, 1.0], [v0, 1.0]]);
        prop_assert!((0..=n).all(|j| part.net().point(m, j) == next.net().point(0, j)));
        let [s, t] = [random.unit(), random.unit()];
        let [u, v] = [low + (high - low) * s, v0 + (1.0 - v0) * t];
        close(patch.net().jet(u, v).point, part.net().jet(s, t).point, 10.0)?;
        prop_assert_eq!(patch.net().restrict([[0.0, 1.0], [0.0, 1.0]]), patch);
    }
}

#[test]
fn periodic_curves_are_smooth_across_the_seam() {
    for degree in 1..6 {
        let mut random = Random(degree as u64);
        let knots = [0.0, 1.0, 1.5, 3.0, 3.2, 4.0];
        let curve = NurbsCurve::periodic("ring", degree, &knots, &random.points(5, 2.0)).expect("good");
        assert_eq!(curve.domain(), [0.0, 4.0]);
        let [start, end] = [curve.jet(0.0), curve.jet(4.0)];
        assert!((start.0 - end.0).length() < 1e-14, "degree {degree}: {start:?} {end:?}");
        assert!(degree == 1 || (start.1 - end.1).length() < 1e-13, "degree {degree}: {start:?} {end:?}");
    }
}

#[test]
fn periodic_surfaces_are_smooth_across_both_seams() {
    let mut random = Random(5);
    let knots = [vec![0.0, 1.0, 1.5, 3.0, 4.0], vec![2.0, 3.0, 5.0, 6.0]];
    let points = random.points(12, 2.0);
    let ring = NurbsSurface::periodic("ring", [3, 2], [4, 3], knots.clone(), &points, [true, true]).expect("good");
    assert_eq!(ring.domain(), [[0.0, 4.0], [2.0, 6.0]]);
    for t in [0.3, 1.5, 3.7] {
        for [a, b] in [[[0.0, 2.0 + t], [4.0, 2.0 + t]], [[t, 2.0], [t, 6.0]]] {
            let [a, b] = [a, b].map(|[u, v]| ring.jet(u, v));
            assert!((a.point - b.point).length() < 1e-14, "{a:?} {b:?}");
            assert!((a.du - b.du).length() + (a.dv - b.dv).length() < 1e-13, "{a:?} {b:?}");
        }
    }
    let short =
        NurbsSurface::periodic("ring", [3, 2], [4, 3], [knots[1].clone(), knots[0].clone()], &points, [true; 2]);
    assert!(short.is_err());
}

#[test]
fn a_jump_at_a_knot_of_multiplicity_above_the_degree_stays() {
    let points = [0.0, 1.0, 5.0, 6.0].map(|x| DVec3::new(x, 0.0, 0.0).extend(1.0)).to_vec();
    let curve = NurbsCurve::new("two lines", 1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0], points).expect("good");
    let pieces = curve.bezier_pieces();
    assert_eq!(pieces.len(), 2);
    assert_eq!([pieces[0].curve.position(1.0).x, pieces[1].curve.position(0.0).x], [1.0, 5.0]);
    assert_eq!([0.5, 1.0, 1.5, 2.0].map(|t| curve.position(t).x), [0.5, 5.0, 5.5, 6.0]);
}
