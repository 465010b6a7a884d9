//! Faces all around a closed surface with loops that cross any seam, against closed forms: areas of surfaces of
//! revolution between angles.

use super::freeform::{cylinders, turned_torus};
use super::*;
use crate::model::{Model, Part};
use proptest::prelude::*;

/// Area by the odd-even rule: it knows nothing of the loops' directions.
fn odd_even_area(face: &Face) -> f64 {
    let model = Model::from_part("", Part { faces: vec![face.clone()], ..Part::default() });
    model.figures(&model.measure(&|_, _| {})).area
}

fn check_both(source: &FaceSource, area: f64) -> Built {
    let built = build_face(source).unwrap();
    measure::closed(&built.face);
    for (how, found) in [("along the loops", measure::area(&built.face)), ("odd-even", odd_even_area(&built.face))] {
        assert!((found - area).abs() < 1e-5 * area, "area {how} {found}, expected {area}; {:#?}", built.face.loops);
    }
    built
}

/// A profile about the frame's z axis that has circles and lines for its lines of constant parameter.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Cylinder,
    Cone,
    Sphere,
    Torus,
}

const TORUS: [f64; 2] = [3.0, 1.0];
const SLOPE: f64 = 0.4;

impl Kind {
    fn surface(self, frame: Frame) -> SurfaceForm {
        match self {
            Self::Cylinder => SurfaceForm::Cylinder { frame, radius: 2.0 },
            Self::Cone => SurfaceForm::Cone { frame, radius: 2.0, half_angle: SLOPE },
            Self::Sphere => SurfaceForm::Sphere { frame, radius: 2.0 },
            Self::Torus => SurfaceForm::Torus { frame, major: TORUS[0], minor: TORUS[1] },
        }
    }

    /// Distance from the axis and height.
    fn profile(self, v: f64) -> [f64; 2] {
        match self {
            Self::Cylinder => [2.0, v],
            Self::Cone => [2.0 + v * SLOPE.tan(), v],
            Self::Sphere => [2.0 * v.cos(), 2.0 * v.sin()],
            Self::Torus => [TORUS[0] + TORUS[1] * v.cos(), TORUS[1] * v.sin()],
        }
    }

    /// Area for one radian about the axis.
    fn area(self, [a, b]: [f64; 2]) -> f64 {
        match self {
            Self::Cylinder => 2.0 * (b - a),
            Self::Cone => 0.5 * (self.profile(a)[0] + self.profile(b)[0]) * (b - a) / SLOPE.cos(),
            Self::Sphere => 4.0 * (b.sin() - a.sin()),
            Self::Torus => TORUS[1] * (TORUS[0] * (b - a) + TORUS[1] * (b.sin() - a.sin())),
        }
    }

    fn around(self, frame: &Frame, v: f64, range: [f64; 2]) -> CurveSpan {
        let [r, z] = self.profile(v);
        circle(raised(*frame, z), r, range)
    }

    fn along(self, frame: &Frame, u: f64, [a, b]: [f64; 2]) -> CurveSpan {
        let x = frame.x * u.cos() + frame.y * u.sin();
        let half = Frame { origin: frame.origin, x, y: frame.z, z: x.cross(frame.z) };
        match self {
            Self::Cylinder | Self::Cone => {
                let [p, q] = [a, b].map(|v| self.profile(v)).map(|[r, z]| frame.origin + x * r + frame.z * z);
                line(p, q)
            }
            Self::Sphere => circle(half, 2.0, [a, b]),
            Self::Torus => circle(Frame { origin: frame.origin + x * TORUS[0], ..half }, TORUS[1], [a, b]),
        }
    }

    /// The loop around a window, with what is outside to its left.
    fn hole(self, frame: &Frame, number: u32, [u0, u1]: [f64; 2], [v0, v1]: [f64; 2]) -> Vec<EdgeUse> {
        vec![
            edge(number, self.along(frame, u0, [v0, v1])),
            edge(number + 1, self.around(frame, v1, [u0, u1])),
            edge(number + 2, self.along(frame, u1, [v1, v0])),
            edge(number + 3, self.around(frame, v0, [u1, u0])),
        ]
    }

    /// The whole turn between two values of v; none of its edges is a seam.
    fn band(self, frame: &Frame, [v0, v1]: [f64; 2], start: f64) -> Vec<Vec<EdgeUse>> {
        let ring = |number, v, range| vec![edge(number, self.around(frame, v, range))];
        vec![ring(1, v0, [start, start + TAU]), ring(2, v1, [start + 1.0 + TAU, start + 1.0])]
    }
}

#[test]
fn hole_across_the_seam_moves_the_seam() {
    let frame = skew();
    for kind in [Kind::Cylinder, Kind::Cone, Kind::Torus] {
        let mut bounds = kind.band(&frame, [0.2, 1.9], 0.0);
        bounds.push(kind.hole(&frame, 10, [-0.4, 0.3], [0.8, 1.3]));
        let area = kind.area([0.2, 1.9]) * TAU - kind.area([0.8, 1.3]) * 0.7;
        let built = check_both(&face(kind.surface(frame), bounds), area);
        assert_eq!(built.face.loops.len(), 2, "the seam can pass the hole by");
    }
}

#[test]
fn torus_with_holes_across_both_seams() {
    let frame = skew();
    let kind = Kind::Torus;
    let holes = [([-0.4, 0.3], [-0.5, 0.6]), ([2.0, 4.0], [2.5, 3.9])];
    let bounds = holes.iter().enumerate().map(|(k, &(u, v))| kind.hole(&frame, 10 * (k as u32 + 1), u, v)).collect();
    let lost: f64 = holes.iter().map(|&(u, v)| kind.area(v) * (u[1] - u[0])).sum();
    check_both(&face(kind.surface(frame), bounds), kind.area([0.0, TAU]) * TAU - lost);
}

/// Circles that wind around a torus both ways (Villarceau's), turned against each other.
#[test]
fn torus_between_two_diagonal_circles() {
    let frame = skew();
    let [major, minor] = TORUS;
    let villarceau = |turn: f64, range: [f64; 2]| {
        let x = frame.x * turn.cos() + frame.y * turn.sin();
        let y = frame.z.cross(x);
        // Through the tube's tangent plane: about a point off the axis by the small radius, of the large radius.
        let tilt = (minor / major).asin();
        let other = y * tilt.cos() + frame.z * tilt.sin();
        let on = Frame { origin: frame.origin + x * minor, x, y: other, z: x.cross(other) };
        circle(on, major, range)
    };
    let whole = Kind::Torus.area([0.0, TAU]) * TAU;
    let surface = SurfaceForm::Torus { frame, major, minor };
    for turn in [0.5, 2.0, 5.0] {
        let (a, b) = (edge(1, villarceau(0.0, [0.0, TAU])), edge(2, villarceau(turn, [0.0, TAU])));
        let parts = [vec![vec![a.clone()], vec![back(&b)]], vec![vec![back(&a)], vec![b]]].map(|bounds| {
            let built = build_face(&face(surface.clone(), bounds)).unwrap();
            measure::closed(&built.face);
            let [along, odd_even] = [measure::area(&built.face), odd_even_area(&built.face)];
            assert!((along - odd_even).abs() < 1e-5 * whole, "{along} and {odd_even}");
            odd_even / whole
        });
        let expected = turn / TAU;
        assert!((parts[0] + parts[1] - 1.0).abs() < 1e-5, "{parts:?}");
        // Which of the two has the material to its left: turning about z moves the circle against its own left.
        let near = parts.map(|part| (part - expected).abs().min((1.0 - part - expected).abs()));
        assert!(near[0] < 1e-5 && (parts[0] - (1.0 - expected)).abs() < 1e-5, "{parts:?} for {expected}");
    }
}

#[test]
fn loops_that_wind_twice_are_named() {
    let frame = skew();
    let twice = vec![
        edge(1, Kind::Cylinder.around(&frame, 0.0, [0.0, TAU])),
        edge(2, Kind::Cylinder.around(&frame, 0.0, [0.0, TAU])),
    ];
    let error = build_face(&face(Kind::Cylinder.surface(frame), vec![twice])).unwrap_err();
    assert!(matches!(error, BrepError::Winding { u: 2, v: 0 }), "{error}");
    let once = vec![edge(1, Kind::Cylinder.around(&frame, 0.0, [0.0, TAU]))];
    let error = build_face(&face(Kind::Cylinder.surface(frame), vec![once])).unwrap_err();
    assert!(matches!(error, BrepError::NoPartner), "{error}");
}

/// The way of the file's own images is the edge's, or they are not used.
#[test]
fn files_own_images_on_a_closed_spline() {
    let frame = skew();
    let surface = turned_torus(&frame, TORUS);
    let kind = Kind::Torus;
    let ranges = ([0.5, 1.4], [0.4, 1.5]);
    let area = kind.area(ranges.1) * 0.9;
    let bound: Vec<EdgeUse> = kind.hole(&frame, 10, ranges.0, ranges.1).iter().rev().map(back).collect();
    let chart = Chart::new(surface.clone(), 1e-7, 1e-9);
    let images: Vec<CurveSpan> = bound
        .iter()
        .map(|edge| {
            let [a, b] = edge.ends.map(|p| chart.invert(p, None, 1e-6));
            line(a.extend(0.0), b.extend(0.0))
        })
        .collect();
    for off in [0.0, 1e-4, 0.3] {
        let mut bound = bound.clone();
        for (edge, image) in bound.iter_mut().zip(&images) {
            let mut image = image.clone();
            if let CurveForm::Line { origin, .. } = &mut image.curve {
                origin.x += off;
            }
            edge.pcurves = vec![vec![image]];
        }
        check_both(&face(surface.clone(), vec![bound]), area);
    }
}

fn kinds() -> impl Strategy<Value = Kind> {
    prop_oneof![Just(Kind::Cylinder), Just(Kind::Cone), Just(Kind::Sphere), Just(Kind::Torus)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Any number of holes anywhere: each in its own strip, so that they do not meet; together they may leave no room
    /// for a straight seam.
    #[test]
    fn holes_anywhere(
        kind in kinds(),
        start in -7.0..7.0,
        lift in 0.0..TAU,
        holes in prop::collection::vec((-7.0..7.0, 0.3..5.9, 0.1..0.9), 1..5),
        form in 0usize..6,
    ) {
        let frame = skew();
        let (low, high) = match kind {
            Kind::Sphere => (-1.4, 1.4),
            Kind::Torus => (lift, lift + TAU),
            _ => (0.0, 3.0),
        };
        let strip = (high - low) / holes.len() as f64;
        let mut bounds = match kind {
            Kind::Cylinder | Kind::Cone => kind.band(&frame, [low, high], start),
            _ => Vec::new(),
        };
        let mut area = match kind {
            Kind::Sphere => kind.area([-PI / 2.0, PI / 2.0]),
            _ => kind.area([low, high]),
        } * TAU;
        for (k, &(u, width, height)) in holes.iter().enumerate() {
            let v = low + strip * (k as f64 + 0.5 * (1.0 - height));
            let range = [v, v + strip * height];
            bounds.push(kind.hole(&frame, 10 * (k as u32 + 1), [u, u + width], range));
            area -= kind.area(range) * width;
        }
        let surface = match (kind, form) {
            (Kind::Cylinder, 0..=4) => cylinders(frame).swap_remove(form),
            (Kind::Torus, 0..=2) => turned_torus(&frame, TORUS),
            _ => kind.surface(frame),
        };
        check_both(&face(surface, bounds), area);
    }
}
