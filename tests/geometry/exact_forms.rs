//! Exact forms lie on their implicit surfaces, at the angle they say, facing outward.

use crate::support::Random;
use glam::DVec3;
use halfpixel::geometry::exact::{self, FULL, Frame, arc_angle, arc_parameter};
use halfpixel::geometry::{BezierCurve, CurvePiece, PatchPiece, SurfacePoint};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Relative error allowed: a handful of roundings.
const EXACT: f64 = 2e-15;

fn frame(random: &mut Random) -> Frame {
    Frame::new(random.vector(), random.vector(), random.vector()).expect("an axis")
}

/// Calls `check` at random points of all pieces with (u, v) in the surface's parameters, both directions angles.
fn sample(
    pieces: &[PatchPiece],
    random: &mut Random,
    angular: [bool; 2],
    mut check: impl FnMut(SurfacePoint, [f64; 2]),
) {
    for piece in pieces {
        for _ in 0..4 {
            let inner = [random.unit(), random.unit()];
            let outer = [0, 1].map(|axis| {
                let [low, high] = piece.domain[axis];
                let s = inner[axis];
                if angular[axis] { arc_angle(s, [low, high]) } else { low + (high - low) * s }
            });
            check(piece.patch.net().surface_point(inner[0], inner[1]), outer);
        }
    }
}

fn near(a: DVec3, b: DVec3, size: f64) {
    assert!((a - b).length() <= EXACT * size, "{a} is not {b}: off by {:e}", (a - b).length());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn spheres(seed: u64, radius in 0.01..100.0, u0 in -7.0..7.0, sweep in 0.1..6.2, v0 in -1.5..0.0) {
        let mut random = Random(seed);
        let f = frame(&mut random);
        let pieces = exact::sphere(&f, radius, [[u0, u0 + sweep], [v0, FRAC_PI_2]]);
        sample(&pieces, &mut random, [true, true], |at, [u, v]| {
            let r = at.position - f.origin;
            assert!((r.length() / radius - 1.0).abs() < EXACT * (1.0 + 1.0 / radius));
            near(at.position, f.point(radius * v.cos() * u.cos(), radius * v.cos() * u.sin(), radius * v.sin()), 4.0 + 4.0 * radius);
            assert!(at.du.cross(at.dv).dot(r) > 0.0);
        });
    }

    #[test]
    fn tori(seed: u64, minor in 0.1..1.0, ratio in 1.1..20.0) {
        let mut random = Random(seed);
        let (f, major) = (frame(&mut random), minor * ratio);
        let pieces = exact::torus(&f, major, minor, [FULL, FULL]);
        prop_assert_eq!(pieces.len(), 16);
        sample(&pieces, &mut random, [true, true], |at, [u, v]| {
            let rho = major + minor * v.cos();
            near(at.position, f.point(rho * u.cos(), rho * u.sin(), minor * v.sin()), 4.0 * (1.0 + major));
            let center = f.point(major * u.cos(), major * u.sin(), 0.0);
            assert!(((at.position - center).length() - minor).abs() < EXACT * (1.0 + major));
            assert!(at.du.cross(at.dv).dot(at.position - center) > 0.0);
        });
    }

    #[test]
    fn cones_and_cylinders(seed: u64, radius in 0.1..10.0, angle in 0.0..1.2, height in 0.1..10.0, u0 in -7.0..7.0) {
        let mut random = Random(seed);
        let f = frame(&mut random);
        let pieces = exact::cone(&f, radius, angle, [[u0, u0 + 5.0], [0.0, height]]);
        sample(&pieces, &mut random, [true, false], |at, [u, v]| {
            let rho = radius + v * angle.tan();
            near(at.position, f.point(rho * u.cos(), rho * u.sin(), v), 4.0 * (1.0 + rho + height));
            let axis_point = f.origin + f.z * v;
            assert!(at.du.cross(at.dv).dot(at.position - axis_point) > 0.0);
        });
    }

    #[test]
    fn revolutions_turn_their_profile(seed: u64, degree in 1usize..6, u0 in -4.0..4.0, sweep in 0.01..6.2) {
        let mut random = Random(seed);
        let f = frame(&mut random);
        let curve = BezierCurve::new("profile", random.points(degree + 1, 3.0)).expect("good");
        let profile = [CurvePiece { curve: curve.clone(), domain: [2.0, 3.0] }];
        let pieces = exact::revolution(&f, &profile, [u0, u0 + sweep]);
        sample(&pieces, &mut random, [true, false], |at, [u, v]| {
            let p = curve.position(v - 2.0) - f.origin;
            let [x, y, z] = [p.dot(f.x), p.dot(f.y), p.dot(f.z)];
            near(at.position, f.point(x * u.cos() - y * u.sin(), x * u.sin() + y * u.cos(), z), 20.0);
        });
    }

    #[test]
    fn extrusions_move_their_profile(seed: u64, degree in 1usize..6) {
        let mut random = Random(seed);
        let curve = BezierCurve::new("profile", random.points(degree + 1, 3.0)).expect("good");
        let direction = random.vector();
        let profile = [CurvePiece { curve: curve.clone(), domain: [2.0, 3.0] }];
        let pieces = exact::extrusion(&profile, direction, [-1.0, 4.0]);
        sample(&pieces, &mut random, [false, false], |at, [u, v]| {
            near(at.position, curve.position(u - 2.0) + direction * v, 20.0);
        });
    }

    #[test]
    fn arc_parameters_invert(a in -7.0..7.0, sweep in 0.01..1.5, t in 0.0..1.0) {
        let range = [a, a + sweep];
        prop_assert!((arc_parameter(arc_angle(t, range), range) - t).abs() < 1e-12 / sweep);
    }
}

#[test]
fn conics_lie_on_their_curves() {
    let mut random = Random(3);
    let f = frame(&mut random);
    for k in 0..=20 {
        let t = k as f64 / 20.0;
        let local = |p: DVec3| [(p - f.origin).dot(f.x), (p - f.origin).dot(f.y)];
        for piece in exact::ellipse(&f, [3.0, 0.5], [0.3, 5.0]) {
            let [x, y] = local(piece.curve.position(t));
            assert!((x * x / 9.0 + y * y / 0.25 - 1.0).abs() < 1e-14);
        }
        let [x, y] = local(exact::hyperbola(&f, [3.0, 0.5], [-1.0, 2.0]).curve.position(t));
        assert!((x * x / 9.0 - y * y / 0.25 - 1.0).abs() < 1e-12);
        let parabola = exact::parabola(&f, 0.7, [-1.0, 2.0]).curve.position(t);
        let s = -1.0 + 3.0 * t;
        near(parabola, f.point(0.7 * s * s, 1.4 * s, 0.0), 10.0);
    }
}

#[test]
fn seams_and_poles_close_bit_for_bit() {
    let f = Frame::new(DVec3::new(3.0, 1.0, -2.0), DVec3::new(1.0, 2.0, 3.0), DVec3::X).expect("an axis");
    let pieces = exact::sphere(&f, 1.7, [FULL, [-FRAC_PI_2, FRAC_PI_2]]);
    assert_eq!(pieces.len(), 8);
    for (k, piece) in pieces.iter().enumerate() {
        let net = piece.patch.net();
        let next = pieces[(k + 2) % 8].patch.net();
        assert!((0..3).all(|j| net.point(2, j) == next.point(0, j)), "meridian {k}");
        let pole = if k % 2 == 0 {
            net.hull().step_by(3).collect::<Vec<_>>()
        } else {
            net.hull().skip(2).step_by(3).collect()
        };
        assert!(pole.iter().all(|p| (*p - pole[0]).length() < 1e-15), "pole {k}: {pole:?}");
    }
    let torus = exact::torus(&f, 2.0, 0.5, [FULL, [PI, 3.0 * PI]]);
    assert!((0..3).all(|j| torus[12].patch.net().point(2, j) == torus[0].patch.net().point(0, j)));
    assert!((0..3).all(|i| torus[3].patch.net().point(i, 2) == torus[0].patch.net().point(i, 0)));
}
