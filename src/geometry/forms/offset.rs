//! Offset surfaces: exact where the base is analytic, else fitted.

use super::{CurveForm, CurveSpan, SurfaceForm};
use crate::geometry::exact::Frame;
use crate::geometry::interpolate::{FIT_DEGREE, coefficients, node, value};
use crate::geometry::{NurbsCurve, NurbsSurface};
use glam::DVec3;

/// Intervals of one parameter that a fit is split into at most; what is off then is stated.
const MAX_INTERVALS: usize = 256;

/// A surface without offsets, and how far it is from what was meant where it is a fit.
pub(super) struct Resolved {
    pub form: SurfaceForm,
    pub error: Option<f64>,
}

/// The same surface without offsets: planes, cylinders, cones, spheres and tori stay what they are with the same
/// parameters; offsets of others become NURBS (or are swept from NURBS) within `tolerance` where that can be had.
pub(super) fn resolved(form: SurfaceForm, tolerance: f64) -> Resolved {
    let SurfaceForm::Offset { base, distance } = form else { return Resolved { form, error: None } };
    let Resolved { form: base, error: before } = resolved(*base, tolerance);
    let d = distance;
    let exact = |form| Resolved { form, error: before };
    let fitted = |(form, error): (SurfaceForm, f64)| Resolved { form, error: Some(error + before.unwrap_or(0.0)) };
    match base {
        SurfaceForm::Plane(frame) => exact(SurfaceForm::Plane(moved(frame, d))),
        SurfaceForm::Cylinder { frame, radius } => exact(SurfaceForm::Cylinder { frame, radius: radius + d }),
        SurfaceForm::Cone { frame, radius, half_angle } => {
            let (s, c) = half_angle.sin_cos();
            exact(SurfaceForm::Cone { frame: moved(frame, -d * s), radius: radius + d * c, half_angle })
        }
        SurfaceForm::Sphere { frame, radius } => exact(SurfaceForm::Sphere { frame, radius: radius + d }),
        SurfaceForm::Torus { frame, major, minor } => exact(SurfaceForm::Torus { frame, major, minor: minor + d }),
        SurfaceForm::Extrusion { profile, direction } => {
            let across = direction.normalize_or_zero();
            let (profile, error) = offset_profile(&profile, tolerance, |p, d| (p, d.cross(across)), d);
            fitted((SurfaceForm::Extrusion { profile, direction }, error))
        }
        SurfaceForm::Revolution { profile, frame } => {
            let normal = |p: DVec3, d: DVec3| (p, frame.z.cross(p - frame.origin).cross(d));
            let (profile, error) = offset_profile(&profile, tolerance, normal, d);
            fitted((SurfaceForm::Revolution { profile, frame }, error))
        }
        SurfaceForm::Nurbs(surface) => fitted(offset_net(surface, d, tolerance)),
        SurfaceForm::Offset { base, distance } => exact(SurfaceForm::Offset { base, distance }),
    }
}

fn moved(frame: Frame, z: f64) -> Frame {
    Frame { origin: frame.origin + frame.z * z, ..frame }
}

/// The knots of Bézier pieces of [`FIT_DEGREE`] between `stops`.
fn joined_knots(stops: &[f64]) -> Vec<f64> {
    let last = stops.len() - 1;
    let count = |k: usize| if k == 0 || k == last { FIT_DEGREE + 1 } else { FIT_DEGREE };
    stops.iter().enumerate().flat_map(|(k, &t)| std::iter::repeat_n(t, count(k))).collect()
}

/// A profile moved by `distance` along the normal that `normal` gives (of any length) for its point and derivative.
fn offset_profile(
    profile: &CurveSpan,
    tolerance: f64,
    normal: impl Fn(DVec3, DVec3) -> (DVec3, DVec3),
    distance: f64,
) -> (CurveSpan, f64) {
    let range = profile.range;
    if !(range[1] - range[0]).is_finite() || range[0] == range[1] {
        return (profile.clone(), f64::INFINITY);
    }
    let range = [range[0].min(range[1]), range[0].max(range[1])];
    let whole = CurveSpan { curve: profile.curve.clone(), range };
    let at = |t: f64| {
        let least = 1e-7 * (range[1] - range[0]);
        let (p, _) = profile.tangent(t);
        // Where the normal vanishes (a point on the axis) it is taken from next to it.
        let normals = [0.0, least, -least].map(|h| profile.tangent((t + h).clamp(range[0], range[1])));
        let n = normals.into_iter().map(|(p, d)| normal(p, d).1).find(|n| n.length() > 1e-12 * p.length().max(1.0));
        p + n.unwrap_or_default().normalize_or_zero() * distance
    };
    let mut stops = whole.breaks();
    loop {
        let mut points = vec![at(stops[0]).extend(1.0)];
        let (mut refined, mut worst) = (vec![stops[0]], 0.0f64);
        for piece in stops.windows(2) {
            let t = |s: f64| piece[0] + (piece[1] - piece[0]) * s;
            let values: [DVec3; FIT_DEGREE + 1] = std::array::from_fn(|k| at(t(node(k, FIT_DEGREE))));
            let fit = coefficients(values.iter().copied());
            let off = |k: usize| {
                let s = node(2 * k + 1, 2 * FIT_DEGREE);
                value(&fit, s).distance(at(t(s)))
            };
            let off = (0..FIT_DEGREE).map(off).fold(0.0, f64::max);
            worst = worst.max(off);
            if off > tolerance {
                refined.push(t(0.5));
            }
            refined.push(piece[1]);
            points.extend(fit[1..].iter().map(|p| p.extend(1.0)));
        }
        if worst <= tolerance || refined.len() > MAX_INTERVALS || refined.len() == stops.len() {
            let curve = NurbsCurve::new("offset profile", FIT_DEGREE, joined_knots(&stops), points);
            return match curve {
                Ok(curve) => (CurveSpan { curve: CurveForm::Nurbs(curve), range }, worst),
                Err(_) => (whole, f64::INFINITY),
            };
        }
        stops = refined;
    }
}

/// Values of the offset at nodes between all stops, one line for each node of u.
fn offset_values(surface: &NurbsSurface, distance: f64, nodes: [&[f64]; 2]) -> Vec<Vec<DVec3>> {
    let domain = surface.domain();
    let middle = domain.map(|[a, b]| 0.5 * (a + b));
    let at = |u: f64, v: f64| {
        let point = surface.surface_point(u, v);
        let normal = point.du.cross(point.dv);
        // At a pole the normal is that of next to it.
        if normal.length() <= 1e-9 * point.du.length().max(point.dv.length()).powi(2) {
            let next = surface.surface_point(u + 1e-6 * (middle[0] - u), v + 1e-6 * (middle[1] - v));
            return point.position + next.du.cross(next.dv).normalize_or_zero() * distance;
        }
        point.position + normal.normalize() * distance
    };
    nodes[0].iter().map(|&u| nodes[1].iter().map(|&v| at(u, v)).collect()).collect()
}

/// Nodes of [`FIT_DEGREE`] in all intervals; those shared by neighbours once.
fn all_nodes(stops: &[f64]) -> Vec<f64> {
    let inside = |w: &[f64]| {
        let [a, b] = [w[0], w[1]];
        (1..=FIT_DEGREE).map(move |k| if k == FIT_DEGREE { b } else { a + (b - a) * node(k, FIT_DEGREE) })
    };
    std::iter::once(stops[0]).chain(stops.windows(2).flat_map(inside)).collect()
}

/// Bernstein coefficients of every interval of a line of values at [`all_nodes`].
fn line_coefficients(line: &[DVec3]) -> Vec<DVec3> {
    let mut points = vec![line[0]];
    for k in (0..line.len() - 1).step_by(FIT_DEGREE) {
        points.extend(&coefficients(line[k..=k + FIT_DEGREE].iter().copied())[1..]);
    }
    points
}

fn offset_net(surface: NurbsSurface, distance: f64, tolerance: f64) -> (SurfaceForm, f64) {
    let stops = surface.knots().each_ref().map(|knots| {
        let mut stops: Vec<f64> = knots.spans().map(|s| knots.interval(s)[0]).collect();
        stops.push(knots.domain()[1]);
        stops
    });
    let mut stops = stops;
    loop {
        let nodes = [all_nodes(&stops[0]), all_nodes(&stops[1])];
        let values = offset_values(&surface, distance, [&nodes[0], &nodes[1]]);
        let lines: Vec<Vec<DVec3>> = values.iter().map(|line| line_coefficients(line)).collect();
        let columns: Vec<Vec<DVec3>> = (0..nodes[1].len())
            .map(|j| line_coefficients(&lines.iter().map(|line| line[j]).collect::<Vec<_>>()))
            .collect();
        let points =
            (0..nodes[0].len()).flat_map(|i| columns.iter().map(move |column| column[i].extend(1.0))).collect();
        let fit = NurbsSurface::new(
            "offset surface",
            [FIT_DEGREE; 2],
            [nodes[0].len(), nodes[1].len()],
            [joined_knots(&stops[0]), joined_knots(&stops[1])],
            points,
        );
        let Ok(fit) = fit else { return (SurfaceForm::Nurbs(surface), f64::INFINITY) };
        let (worst, refined) = refined(&surface, &fit, distance, &stops, tolerance);
        let large = refined.iter().any(|stops| stops.len() > MAX_INTERVALS)
            || refined[0].len() * refined[1].len() > 4 * MAX_INTERVALS;
        if worst <= tolerance || large {
            return (SurfaceForm::Nurbs(fit), worst);
        }
        stops = refined;
    }
}

/// How far the fit is off, and the stops with those intervals halved where it is too far.
fn refined(
    surface: &NurbsSurface,
    fit: &NurbsSurface,
    distance: f64,
    stops: &[Vec<f64>; 2],
    tolerance: f64,
) -> (f64, [Vec<f64>; 2]) {
    let middles = stops.each_ref().map(|stops| {
        let near = [0.35, 0.6];
        stops.windows(2).flat_map(move |w| near.map(|s| w[0] + (w[1] - w[0]) * s)).collect::<Vec<f64>>()
    });
    let truth = offset_values(surface, distance, [&middles[0], &middles[1]]);
    let mut worst = 0.0f64;
    let mut halve = stops.each_ref().map(|stops| vec![false; stops.len() - 1]);
    for (i, (&u, line)) in middles[0].iter().zip(&truth).enumerate() {
        for (j, (&v, p)) in middles[1].iter().zip(line).enumerate() {
            let off = fit.position(u, v).distance(*p);
            worst = worst.max(off);
            if off > tolerance {
                (halve[0][i / 2], halve[1][j / 2]) = (true, true);
            }
        }
    }
    let split = |axis: usize| {
        let inside = |(w, &halve): (&[f64], &bool)| {
            halve.then(|| 0.5 * (w[0] + w[1])).into_iter().chain([w[1]]).collect::<Vec<_>>()
        };
        let rest = stops[axis].windows(2).zip(&halve[axis]).flat_map(inside);
        std::iter::once(stops[axis][0]).chain(rest).collect()
    };
    (worst, [split(0), split(1)])
}
