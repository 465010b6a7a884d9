//! Hard cases, each a small part of its own.

use super::{closed, part, sphere, torus};
use crate::geometry::exact::{self, Frame};
use crate::geometry::{BezierPatch, PatchPiece};
use crate::model::{Instance, Model, Part, Solidity, Surface};
use glam::{DAffine3, DVec3};

/// Highest degree of the `degreeN` graphs.
const TOP_DEGREE: usize = 25;

/// Cases about one unit large that can stand side by side.
const SMALL: [&str; 7] = ["weights", "collapsed", "coincident", "twist", "moebius", "tiny", "double"];

/// Cases that need a scene of their own.
const LONE: [&str; 6] = ["offset1e6", "offset1e9", "scale1e-6", "scale1e6", "nearplane", "room"];

/// All names without `stress:`.
pub fn names() -> Vec<String> {
    let degrees = (1..=TOP_DEGREE).map(|degree| format!("degree{degree}"));
    SMALL.iter().chain(&LONE).map(|name| name.to_string()).chain(degrees).collect()
}

/// All small cases and the degrees, six to a row, in one scene.
pub fn table() -> Model {
    let is_small = |name: &String| !LONE.contains(&name.as_str());
    let parts: Vec<Part> = names().iter().filter(|name| is_small(name)).filter_map(|name| part_of(name)).collect();
    let instance = |(k, part): (usize, &Part)| {
        let transform = DAffine3::from_translation(DVec3::new(1.5 * (k % 6) as f64, 1.5 * (k / 6) as f64, 0.0));
        Instance { part: k, transform, name: part.name.clone(), ..Instance::default() }
    };
    let instances = parts.iter().enumerate().map(instance).collect();
    Model { name: "stress".into(), parts, instances, ..Model::default() }
}

/// One case by its name without `stress:`.
pub fn part_of(name: &str) -> Option<Part> {
    let open = |surfaces: Vec<Surface>| part(name, Solidity::Open, surfaces);
    let moved = |map: DAffine3| closed(name, vec![transformed(torus(1.0, 0.4), &map)]);
    Some(match name {
        "offset1e6" => moved(DAffine3::from_translation(DVec3::new(1e6, -1e6, 1e6))),
        "offset1e9" => moved(DAffine3::from_translation(DVec3::new(1e9, -1e9, 1e9))),
        "scale1e-6" => moved(DAffine3::from_scale(DVec3::splat(1e-6))),
        "scale1e6" => moved(DAffine3::from_scale(DVec3::splat(1e6))),
        "weights" => open(vec![weights()]),
        "collapsed" => open(collapsed()),
        "coincident" => open(coincident()),
        "twist" => open(vec![patch([1, 1], |s, t| DVec3::new(s, t, if s == t { 0.4 } else { 0.0 }), |_, _| 1.0)]),
        "moebius" => open(vec![moebius()]),
        "tiny" => open(tiny()),
        "double" => open(vec![wave(3), wave(3)]),
        "nearplane" => open(vec![nearplane()]),
        "room" => open(room()),
        _ => {
            let degree = (1..=TOP_DEGREE).find(|degree| name == format!("degree{degree}"))?;
            open(vec![wave(degree)])
        }
    })
}

/// A patch from functions of the control point's place (i/m, j/n) in the net: position, weight.
fn patch(degree: [usize; 2], point: impl Fn(f64, f64) -> DVec3, weight: impl Fn(f64, f64) -> f64) -> Surface {
    let [m, n] = degree;
    let places = (0..=m).flat_map(|i| (0..=n).map(move |j| (i as f64 / m as f64, j as f64 / n as f64)));
    let points = places.map(|(s, t)| (point(s, t) * weight(s, t)).extend(weight(s, t)));
    Surface::single(BezierPatch::from_points(degree, points.collect()))
}

fn transformed(mut pieces: Vec<PatchPiece>, map: &DAffine3) -> Vec<PatchPiece> {
    pieces.iter_mut().for_each(|piece| piece.patch = piece.patch.transformed(map));
    pieces
}

/// A graph over the unit square. Bernstein polynomials flatten control waves the more the higher the degree, so the
/// waves' height grows with it.
pub(super) fn wave(degree: usize) -> Surface {
    let d = degree as f64;
    let height = 0.15 + 0.02 * d;
    let point = |s: f64, t: f64| {
        // Some three control points a half wave, at most three waves, out of step in the two directions.
        let waves = (d / 6.0).clamp(0.5, 3.0) * std::f64::consts::TAU;
        DVec3::new(s, t, height * (waves * s + 0.4).sin() * (waves * t + 1.1).cos())
    };
    patch([degree, degree], point, |_, _| 1.0)
}

/// Weights from 1e-3 to 1e3 in one bicubic patch, large next to small.
fn weights() -> Surface {
    let exponents = [[0, 3, -3, 1], [-2, 2, 1, -3], [3, -1, 0, 2], [-3, 1, 3, 0]];
    let weight = |s: f64, t: f64| 10f64.powi(exponents[(3.0 * s).round() as usize][(3.0 * t).round() as usize]);
    patch([3, 3], |s, t| DVec3::new(s, t, 0.3 * (5.0 * s + 2.0).sin() * (4.0 * t).cos()), weight)
}

/// A triangle (one collapsed edge), a lune (two opposite ones), and the poles of a sphere.
fn collapsed() -> Vec<Surface> {
    let bulge = |s: f64, t: f64| 0.3 * (4.0 * s * (1.0 - s)) * (0.5 + t);
    let triangle = patch([3, 3], |s, t| DVec3::new(0.4 * s, 0.4 * s * t, bulge(s, t)), |_, _| 1.0);
    let lune = patch(
        [3, 2],
        |s, t| DVec3::new(0.5 + 0.4 * s, 0.6 * (t - 0.5) * if s * (1.0 - s) > 0.0 { 1.0 } else { 0.0 }, bulge(s, t)),
        |_, _| 1.0,
    );
    let ball = transformed(sphere(0.2), &DAffine3::from_translation(DVec3::new(0.3, 0.75, 0.2)));
    vec![triangle, lune, ball.into()]
}

/// Doubled control points inside (derivatives vanish where the surface is smooth), a patch folded into a line, a patch
/// that is a point.
fn coincident() -> Vec<Surface> {
    let snap = |s: f64| (2.0 * s).round() / 2.0;
    let doubled = patch([4, 4], |s, t| DVec3::new(snap(s), snap(t), 0.3 * (6.0 * snap(s) * snap(t)).sin()), |_, _| 1.0);
    let cusp = patch([3, 3], |s, t| DVec3::new(0.5 * s, t, if s * (1.0 - s) > 0.0 { 0.5 } else { 0.2 }), |_, _| 1.0);
    let line = patch([3, 3], |s, t| DVec3::new(s * t, 0.2, 0.6), |_, _| 1.0);
    let point = patch([2, 2], |_, _| DVec3::new(0.5, 0.5, 0.8), |_, _| 1.0);
    vec![doubled, cusp, line, point]
}

/// The unit square with weights 8^(i+j): the same plane, run through by a Möbius map in each direction.
fn moebius() -> Surface {
    patch([3, 3], |s, t| DVec3::new(s, t, 0.0), |s, t| 8f64.powi((3.0 * (s + t)).round() as i32))
}

/// A patch that covers about 1/100 pixel where the unit square about it fills a picture of 1000 pixels.
fn tiny() -> Vec<Surface> {
    let size = 1e-5;
    let small = |s: f64, t: f64| DVec3::new(0.5 + size * s, 0.5 + size * t, 0.3 + size * s * t);
    vec![patch([1, 1], |s, t| DVec3::new(s, t, 0.0), |_, _| 1.0), patch([3, 3], small, |_, _| 1.0)]
}

/// A ribbon 2000 long and 2 wide that passes the eye wherever it stands.
fn nearplane() -> Surface {
    patch([5, 3], |s, t| DVec3::new(2000.0 * (s - 0.5), 2.0 * (t - 0.5), (9.0 * s).sin() * (3.0 * t).cos()), |_, _| 1.0)
}

/// A box of 10 by 10 by 6 with its normals inward and a ball in its middle; every ray from within hits something.
fn room() -> Vec<Surface> {
    let [x, y, z] = [5.0, 5.0, 3.0];
    let wall = |axis: DVec3, reference: DVec3, [distance, half_u, half_v]: [f64; 3]| {
        // The frame's z looks back to the middle.
        let frame = Frame::new(-axis * distance, axis, reference)?;
        Some(vec![exact::plane(&frame, [[-half_u, half_u], [-half_v, half_v]])].into())
    };
    let walls = [
        wall(DVec3::X, DVec3::Y, [x, y, z]),
        wall(DVec3::NEG_X, DVec3::Y, [x, y, z]),
        wall(DVec3::Y, DVec3::X, [y, x, z]),
        wall(DVec3::NEG_Y, DVec3::X, [y, x, z]),
        wall(DVec3::Z, DVec3::X, [z, x, y]),
        wall(DVec3::NEG_Z, DVec3::X, [z, x, y]),
    ];
    walls.into_iter().flatten().chain([sphere(1.0).into()]).collect()
}
