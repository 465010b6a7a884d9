//! Trimmed faces and solids whose trim curves are exact: what no other program has to confirm.

use super::stress;
use crate::geometry::exact::{self, FULL, Frame};
use crate::geometry::{BezierCurve, CurvePiece};
use crate::model::{Face, Loop, Part, Solidity, Surface, SurfaceKind, TrimCurve};
use glam::{DVec2, DVec3, DVec4};

/// All names without `trimmed:`.
pub const NAMES: [&str; 8] = ["plate", "wedge", "drilled", "gap", "ball", "bowl", "degree22", "touching"];

/// How far the bore of `gap` is from the circles that it should meet; the edge lies half way.
const GAP: f64 = 2e-3;
/// Slope and height of the plane that cuts `wedge`: z = SLOPE x + TOP.
const SLOPE: f64 = 0.5;
const TOP: f64 = 0.5;

/// One case by its name without `trimmed:`.
///
/// `plate` has 96 round holes, two of every three filled again by an island; `wedge` is a cylinder cut off by a slanted
/// plane and `drilled` a cube with a bore, both closed without gaps; `gap` is `drilled` with a bore that misses its edges
/// by 0.002; `ball` is a sphere with a hole in each octant and `bowl` the lower half of one; `degree22` has a surface and
/// a loop of that degree; `touching` has holes that touch, meet in a point, or leave bridges down to 1e-9.
pub fn part_of(name: &str) -> Option<Part> {
    let (solidity, faces) = match name {
        "plate" => (Solidity::Open, vec![plate()]),
        "wedge" => (Solidity::Solid, wedge()),
        "drilled" => (Solidity::Solid, drilled(0.0)),
        "gap" => (Solidity::Open, drilled(GAP)),
        "ball" => (Solidity::Open, vec![ball()]),
        "bowl" => (Solidity::Open, vec![bowl()]),
        "degree22" => (Solidity::Open, vec![degree22()]),
        "touching" => (Solidity::Open, vec![touching()]),
        _ => return None,
    };
    Some(Part { name: name.into(), faces, solidity, ..Part::default() })
}

fn face(id: u32, kind: SurfaceKind, surface: Surface, loops: Vec<Loop>) -> Face {
    Face { kind, loops: loops.into(), ..Face::new(id, format!("trimmed {id}"), surface) }
}

fn plane(frame: &Frame, half: [f64; 2]) -> Surface {
    vec![exact::plane(frame, half.map(|h| [-h, h]))].into()
}

/// A curve on an edge that its face shares, or (`None`) along a seam.
fn curve(curve: BezierCurve, edge: Option<u32>) -> TrimCurve {
    TrimCurve { curve, gap: 0.0, edge }
}

fn line(a: [f64; 2], b: [f64; 2], edge: Option<u32>) -> TrimCurve {
    curve(BezierCurve::line(DVec2::from(a).extend(0.0), DVec2::from(b).extend(0.0)), edge)
}

fn polygon(corners: &[[f64; 2]], edge: u32) -> Loop {
    let side = |k: usize| line(corners[k], corners[(k + 1) % corners.len()], Some(edge + k as u32));
    Loop { curves: (0..corners.len()).map(side).collect() }
}

fn rectangle(half: [f64; 2], edge: u32) -> Loop {
    let [u, v] = half;
    polygon(&[[-u, -v], [u, -v], [u, v], [-u, v]], edge)
}

/// An ellipse about a point of the plane, along its axes.
fn ellipse(center: [f64; 2], radii: [f64; 2], edge: u32) -> Loop {
    let frame = Frame { origin: DVec2::from(center).extend(0.0), ..Frame::IDENTITY };
    let mut curves: Vec<TrimCurve> =
        exact::ellipse(&frame, radii, FULL).into_iter().map(|piece| curve(piece.curve, Some(edge))).collect();
    // The last arc ends at sine of a whole turn: bit for bit where the first one starts.
    close(&mut curves);
    Loop { curves }
}

/// Moves each curve's end to the next one's start, which is there but for rounding.
fn close(curves: &mut [TrimCurve]) {
    let starts: Vec<DVec4> = curves.iter().map(|c| c.curve.points()[0]).collect();
    for (k, piece) in curves.iter_mut().enumerate() {
        let mut points = piece.curve.points().to_vec();
        let (last, next) = (points.len() - 1, starts[(k + 1) % starts.len()]);
        points[last] = next * (points[last].w / next.w);
        if let Ok(closed) = BezierCurve::new("a built-in loop", points) {
            piece.curve = closed;
        }
    }
}

fn plate() -> Face {
    let mut loops = vec![rectangle([1.5, 1.0], 1)];
    for i in 0..12 {
        for j in 0..8 {
            let center = [0.25 * f64::from(i) - 1.375, 0.25 * f64::from(j) - 0.875];
            let edge = 100 + 10 * (8 * i + j);
            loops.push(ellipse(center, [0.1, 0.1], edge as u32));
            if (i + j) % 3 > 0 {
                loops.push(ellipse(center, [0.06, 0.03 + 0.002 * f64::from(i)], edge as u32 + 5));
            }
        }
    }
    face(1, SurfaceKind::Plane, plane(&Frame::IDENTITY, [1.5, 1.0]), loops)
}

/// The unit cylinder from z = -1 to the plane z = SLOPE x + TOP, closed by discs.
fn wedge() -> Vec<Face> {
    let side = exact::cylinder(&Frame::IDENTITY, 1.0, [FULL, [-1.0, 1.5]]);
    let arcs = exact::circle(&Frame::IDENTITY, 1.0, FULL);
    let (start, end) = (FULL[0], FULL[1]);
    let height = |x: f64| SLOPE * x + TOP;
    let mut curves: Vec<TrimCurve> =
        arcs.iter().map(|arc| line([arc.domain[0], -1.0], [arc.domain[1], -1.0], Some(10))).collect();
    curves.push(line([end, -1.0], [end, height(1.0)], None));
    curves.extend(arcs.iter().rev().map(|arc| curve(cut_of(arc).reversed(), Some(11))));
    curves.push(line([start, height(1.0)], [start, -1.0], None));
    close(&mut curves);
    let slope = DVec3::new(1.0, 0.0, SLOPE).normalize();
    let slanted = Frame { origin: DVec3::Z * TOP, x: slope, y: DVec3::Y, z: slope.cross(DVec3::Y) };
    let below = Frame { origin: -DVec3::Z, x: DVec3::X, y: -DVec3::Y, z: -DVec3::Z };
    let long = (1.0 + SLOPE * SLOPE).sqrt();
    vec![
        face(1, SurfaceKind::Cylinder, side.into(), vec![Loop { curves }]),
        face(2, SurfaceKind::Plane, plane(&slanted, [1.3, 1.2]), vec![ellipse([0.0; 2], [long, 1.0], 11)]),
        face(3, SurfaceKind::Plane, plane(&below, [1.0, 1.0]), vec![ellipse([0.0; 2], [1.0; 2], 10)]),
    ]
}

/// Where the slanted plane cuts an arc's strip of the unit cylinder, in the parameter plane: u is linear and the height
/// rational in the arc's parameter, which makes a rational cubic.
fn cut_of(arc: &CurvePiece) -> BezierCurve {
    let [a, b] = arc.domain;
    let points = arc.curve.points();
    let [w0, w1, w2] = [0, 1, 2].map(|k| points[k].w);
    let [z0, z1, z2] = [0, 1, 2].map(|k| SLOPE * points[k].x + TOP * points[k].w);
    let cubic = |p: [f64; 3]| [p[0], (p[0] + 2.0 * p[1]) / 3.0, (2.0 * p[1] + p[2]) / 3.0, p[2]];
    let u = [a * w0, (2.0 * a * w1 + b * w0) / 3.0, (a * w2 + 2.0 * b * w1) / 3.0, b * w2];
    let (v, w) = (cubic([z0, z1, z2]), cubic([w0, w1, w2]));
    BezierCurve::from_points((0..4).map(|k| DVec4::new(u[k], v[k], 0.0, w[k])).collect())
}

/// The cube [-1, 1]³ with a bore of radius 0.6 along z; the bore is too narrow by `gap`.
fn drilled(gap: f64) -> Vec<Face> {
    const RADIUS: f64 = 0.6;
    let turned = |x: DVec3, z: DVec3| Frame { origin: z, x, y: z.cross(x), z };
    let mut faces = Vec::new();
    let sides = [(DVec3::Y, DVec3::X), (-DVec3::X, DVec3::Y), (-DVec3::Y, -DVec3::X), (DVec3::X, -DVec3::Y)];
    for (k, (x, z)) in sides.into_iter().enumerate() {
        let loops = vec![rectangle([1.0, 1.0], 20 + 4 * k as u32)];
        faces.push(face(1 + k as u32, SurfaceKind::Plane, plane(&turned(x, z), [1.0, 1.0]), loops));
    }
    for (k, z) in [DVec3::Z, -DVec3::Z].into_iter().enumerate() {
        let mut loops = vec![rectangle([1.0, 1.0], 40), ellipse([0.0; 2], [RADIUS; 2], 50 + k as u32)];
        loops[1].curves.iter_mut().for_each(|c| c.gap = 0.5 * gap);
        faces.push(face(5 + k as u32, SurfaceKind::Plane, plane(&turned(DVec3::X, z), [1.0, 1.0]), loops));
    }
    let bore = exact::cylinder(&Frame::IDENTITY, RADIUS - gap, [FULL, [-1.0, 1.0]]);
    let [(a, low), (b, high)] = [(FULL[0], -1.0), (FULL[1], 1.0)];
    let mut around =
        [line([a, low], [b, low], Some(51)), line([b, low], [b, high], None), line([b, high], [a, high], Some(50))]
            .to_vec();
    around.push(line([a, high], [a, low], None));
    around.iter_mut().filter(|c| c.edge.is_some()).for_each(|c| c.gap = 0.5 * gap);
    let loops = vec![Loop { curves: around }];
    faces.push(Face { reversed: true, ..face(7, SurfaceKind::Cylinder, bore.into(), loops) });
    faces
}

fn ball() -> Face {
    let [u, v] = [FULL, [-0.5 * std::f64::consts::PI, 0.5 * std::f64::consts::PI]];
    let corners = [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]];
    let mut around = polygon(&corners, 1);
    around.curves.iter_mut().for_each(|c| c.edge = None);
    let mut loops = vec![around];
    for k in 0..8 {
        let center = [(0.5 + f64::from(k % 4)) * 0.25 * FULL[1], if k < 4 { -0.8 } else { 0.8 }];
        loops.push(ellipse(center, [0.3 + 0.05 * f64::from(k), 0.7], 10 + k as u32));
    }
    face(1, SurfaceKind::Sphere, exact::sphere(&Frame::IDENTITY, 1.0, [u, v]).into(), loops)
}

/// The lower half of the unit sphere, cut along the equator, where patches meet: nothing is left to test.
fn bowl() -> Face {
    let south = -0.5 * std::f64::consts::PI;
    let corners = [[FULL[0], south], [FULL[1], south], [FULL[1], 0.0], [FULL[0], 0.0]];
    let mut around = polygon(&corners, 1);
    for k in [0, 1, 3] {
        around.curves[k].edge = None;
    }
    let sphere = exact::sphere(&Frame::IDENTITY, 1.0, [FULL, [south, -south]]);
    face(1, SurfaceKind::Sphere, sphere.into(), vec![around])
}

fn degree22() -> Face {
    let turn = |k: usize| std::f64::consts::TAU * k as f64 / 22.0;
    // The control points of a star: the curve itself is smoother.
    let point = |k: usize| {
        let radius = if k.is_multiple_of(2) { 0.48 } else { 0.3 };
        let angle = turn(k % 22);
        DVec4::new(0.5 + radius * angle.cos(), 0.5 + radius * angle.sin(), 0.0, 1.0)
    };
    let star = BezierCurve::from_points((0..=22).map(point).collect());
    let loops = vec![Loop { curves: vec![curve(star, Some(1))] }, ellipse([0.5, 0.5], [0.1, 0.05], 2)];
    face(1, SurfaceKind::Bezier, stress::wave(22), loops)
}

fn touching() -> Face {
    let mut loops = vec![rectangle([1.5, 1.0], 1)];
    // Pairs of holes with a bridge between them, the last pairs touching and overlapping (an overlap is solid again).
    for (k, bridge) in [1e-2, 1e-3, 1e-5, 1e-9, 0.0, -0.05].into_iter().enumerate() {
        let u = 0.45 * k as f64 - 1.15;
        loops.push(ellipse([u, 0.5 + 0.1 + bridge * 0.5], [0.15, 0.1], 10 + 2 * k as u32));
        loops.push(ellipse([u, 0.5 - 0.1 - bridge * 0.5], [0.15, 0.1], 11 + 2 * k as u32));
    }
    // A hole that touches the outline along a side, one in a point, one given twice, and needles.
    loops.push(polygon(&[[-1.5, -0.5], [-1.2, -0.5], [-1.2, -0.2], [-1.5, -0.2]], 30));
    loops.push(ellipse([-0.8, -0.8], [0.2, 0.2], 34));
    loops.extend([ellipse([-0.2, -0.5], [0.2, 0.3], 35), ellipse([-0.2, -0.5], [0.2, 0.3], 36)]);
    for k in 0..8 {
        let u = 0.2 + 0.12 * f64::from(k);
        loops.push(polygon(&[[u, -0.9], [u + 0.1 * 0.3f64.powi(k), -0.9], [u + 0.05, -0.1]], 40 + 3 * k as u32));
    }
    face(1, SurfaceKind::Plane, plane(&Frame::IDENTITY, [1.5, 1.0]), loops)
}
