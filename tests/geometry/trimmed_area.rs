//! Area inside trim loops: closed forms, and counting points on a fine grid.

use glam::{DMat3, DVec2, DVec3, DVec4};
use halfpixel::geometry::exact::{FULL, Frame, arc_parameter, cylinder, plane, sphere};
use halfpixel::geometry::{BezierCurve, Estimate, Outline, PatchPiece, Tile, trimmed_area};
use std::f64::consts::{FRAC_PI_2, PI};

fn polygon(points: &[DVec2]) -> Vec<BezierCurve> {
    let side = |k: usize| BezierCurve::line(points[k].extend(0.0), points[(k + 1) % points.len()].extend(0.0));
    (0..points.len()).map(side).collect()
}

fn rectangle([[u0, u1], [v0, v1]]: [[f64; 2]; 2]) -> Vec<BezierCurve> {
    polygon(&[DVec2::new(u0, v0), DVec2::new(u1, v0), DVec2::new(u1, v1), DVec2::new(u0, v1)])
}

fn circle(center: DVec2, radius: f64) -> Vec<BezierCurve> {
    let w = 0.5_f64.sqrt();
    let corner = |k: usize| {
        let (reach, w) = if k % 2 == 1 { (radius / w, w) } else { (radius, 1.0) };
        let p = center + DVec2::from_angle(k as f64 * PI / 4.0) * reach;
        DVec4::new(p.x * w, p.y * w, 0.0, w)
    };
    (0..4).map(|k| BezierCurve::new("circle", (2 * k..2 * k + 3).map(corner).collect()).unwrap()).collect()
}

fn reversed(curves: &[BezierCurve]) -> Vec<BezierCurve> {
    curves.iter().rev().map(BezierCurve::reversed).collect()
}

fn area(pieces: &[PatchPiece], loops: &[Vec<BezierCurve>]) -> Estimate {
    let tiles: Vec<Tile> = pieces.iter().map(|p| Tile { net: p.patch.net(), domain: p.domain }).collect();
    let outlines: Vec<Outline> = loops.iter().map(|l| l.iter().collect()).collect();
    trimmed_area(&tiles, &outlines, DMat3::IDENTITY, 1e-9)
}

#[track_caller]
fn assert_area(found: Estimate, exact: f64, relative: f64) {
    assert!((found.value / exact - 1.0).abs() < relative, "{found:?}, not {exact}");
    assert!(found.error < 1e-6 * exact && (found.value - exact).abs() < found.error + 1e-9 * exact, "{found:?}");
}

#[test]
fn plane_with_holes_and_an_island_however_they_run() {
    let base = plane(&Frame::IDENTITY, [[-10.0, 10.0]; 2]);
    let square = rectangle([[-8.0, 8.0], [-9.0, 9.0]]);
    let (hole, island, other) =
        (circle(DVec2::ZERO, 4.0), circle(DVec2::new(1.0, 0.5), 2.0), circle(DVec2::splat(6.5), 1.5));
    let exact = 16.0 * 18.0 - PI * 16.0 + PI * 4.0 - PI * 2.25;
    for turn in 0..16 {
        let of = |bit: i32, l: &Vec<BezierCurve>| if turn >> bit & 1 == 1 { reversed(l) } else { l.clone() };
        let loops = [of(0, &hole), of(1, &square), of(2, &island), of(3, &other)];
        assert_area(area(std::slice::from_ref(&base), &loops), exact, 1e-9);
    }
    // The hole touches the outer loop from within, in a corner and along a side.
    let touching = [square.clone(), rectangle([[6.0, 8.0], [7.0, 9.0]])];
    assert_area(area(std::slice::from_ref(&base), &touching), 16.0 * 18.0 - 4.0, 1e-12);
}

#[test]
fn cylinder_and_sphere_zones() {
    let frame = Frame::new(DVec3::new(3.0, -2.0, 5.0), DVec3::new(1.0, 2.0, 3.0), DVec3::X).unwrap();
    let tube = cylinder(&frame, 2.5, [FULL, [-1.0, 7.0]]);
    assert_area(area(&tube, &[rectangle([FULL, [0.5, 6.0]])]), 2.0 * PI * 2.5 * 5.5, 1e-9);
    // Zones of a sphere, from latitude to latitude and over a third of a turn.
    let ball = sphere(&frame, 1.5, [FULL, [-FRAC_PI_2, FRAC_PI_2]]);
    let height = |latitude: f64| {
        let span = if latitude < 0.0 { [-FRAC_PI_2, 0.0] } else { [0.0, FRAC_PI_2] };
        span[0] + (span[1] - span[0]) * arc_parameter(latitude, span)
    };
    let longitude = |angle: f64| {
        let start = (angle / FRAC_PI_2).floor() * FRAC_PI_2;
        start + FRAC_PI_2 * arc_parameter(angle, [start, start + FRAC_PI_2])
    };
    for [low, high] in [[-1.2, 0.9], [0.1, 0.3], [-FRAC_PI_2, FRAC_PI_2]] {
        let range = [height(low), height(high)];
        let zone = 2.0 * PI * 2.25 * (high.sin() - low.sin());
        assert_area(area(&ball, &[rectangle([FULL, range])]), zone, 1e-8);
        let part = [longitude(1.0), longitude(1.0 + 2.0 * PI / 3.0)];
        assert_area(area(&ball, &[rectangle([part, range])]), zone / 3.0, 1e-8);
    }
}

/// 3x2 bicubic patches of a bumpy sheet.
fn sheet() -> Vec<PatchPiece> {
    let at = |x: f64, y: f64| DVec3::new(x, y + 0.1 * (2.0 * x).sin(), 0.4 * (1.7 * x).sin() * (1.3 * y).cos());
    let piece = |a: usize, b: usize| {
        let weight = |i: usize, j: usize| 1.0 + 0.3 * ((i * 2 + j * 3) % 4) as f64;
        let point = |i: usize, j: usize| {
            let w = weight(i, j);
            (at(a as f64 + i as f64 / 3.0, b as f64 + j as f64 / 3.0) * w).extend(w)
        };
        let points = (0..16).map(|k| point(k / 4, k % 4)).collect();
        let patch = halfpixel::geometry::BezierPatch::new("sheet", [3, 3], points).unwrap();
        PatchPiece { patch, domain: [[a as f64, a as f64 + 1.0], [b as f64, b as f64 + 1.0]] }
    };
    (0..6).map(|k| piece(k / 2, k % 2)).collect()
}

#[test]
fn bumpy_sheet_as_counted() {
    let pieces = sheet();
    let triangle = polygon(&[DVec2::new(0.1, 0.2), DVec2::new(2.9, 0.4), DVec2::new(1.2, 1.9)]);
    let hole = circle(DVec2::new(1.3, 0.9), 0.4);
    let found = area(&pieces, &[reversed(&hole), triangle.clone()]);
    let inside = |p: DVec2| {
        let corner = |k: usize| triangle[k % 3].position(0.0).truncate();
        let left = |k: usize| (corner(k + 1) - corner(k)).perp_dot(p - corner(k)) > 0.0;
        (0..3).all(left) && p.distance(DVec2::new(1.3, 0.9)) > 0.4
    };
    let n = 1200;
    let mut counted = 0.0;
    for piece in &pieces {
        let cell = |k: usize| (k as f64 + 0.5) / f64::from(n);
        for (i, j) in (0..n as usize).flat_map(|i| (0..n as usize).map(move |j| (i, j))) {
            let p = DVec2::new(piece.domain[0][0] + cell(i), piece.domain[1][0] + cell(j));
            if inside(p) {
                let at = piece.patch.net().surface_point(cell(i), cell(j));
                counted += at.du.cross(at.dv).length() / f64::from(n * n);
            }
        }
    }
    // What such a grid misses at the borders.
    assert!((found.value / counted - 1.0).abs() < 3e-5, "{found:?}, counted {counted}");
    assert!(found.error < 1e-6 * counted, "{found:?}");
    // The whole sheet is all of its patches.
    let whole = area(&pieces, &[rectangle([[0.0, 3.0], [0.0, 2.0]])]);
    let sum: f64 =
        pieces.iter().map(|p| halfpixel::geometry::patch_area(p.patch.net(), DMat3::IDENTITY, 1e-9).value).sum();
    assert_area(whole, sum, 1e-7);
}

#[test]
fn outlines_without_area_and_surfaces_without_patches() {
    let base = plane(&Frame::IDENTITY, [[0.0, 1.0]; 2]);
    let line = polygon(&[DVec2::new(0.2, 0.2), DVec2::new(0.8, 0.7)]);
    assert!(area(std::slice::from_ref(&base), std::slice::from_ref(&line)).value.abs() < 1e-12);
    assert_eq!(area(&[], &[line]), Estimate::default());
    assert_eq!(area(&[base], &[vec![]]).value, 0.0);
}

#[test]
fn outlines_that_cross_each_other_or_themselves() {
    let base = plane(&Frame::IDENTITY, [[-10.0, 10.0]; 2]);
    let base = std::slice::from_ref(&base);
    // Discs: what both share is outside.
    for apart in [0.3, 1.0, 1.9] {
        let (a, b) = (circle(DVec2::ZERO, 1.0), circle(DVec2::new(apart * 0.6, apart * 0.8), 1.0));
        let lens = 2.0 * (0.5 * apart).acos() - 0.5 * apart * (4.0 - apart * apart).sqrt();
        assert_area(area(base, &[a, b]), 2.0 * PI - 2.0 * lens, 1e-7);
    }
    // A pentagram runs twice around its middle, which is outside: five points of it are left.
    let corner = |k: usize| DVec2::from_angle((2 * k) as f64 * 0.4 * PI) * 5.0;
    let star: Vec<DVec2> = (0..5).map(corner).collect();
    let (s, c) = (0.2 * PI).sin_cos();
    let inner = 5.0 * (0.4 * PI).cos() / c;
    let [whole, middle] = [10.0 * 5.0 * inner * s * 0.5, 2.5 * inner * inner * (0.4 * PI).sin()];
    assert_area(area(base, &[polygon(&star)]), whole - middle, 1e-7);
    // A bow tie whose two halves run against each other, and a hole across its knot.
    let tie = polygon(&[DVec2::new(-2.0, -1.0), DVec2::new(2.0, 1.0), DVec2::new(2.0, -1.0), DVec2::new(-2.0, 1.0)]);
    assert_area(area(base, std::slice::from_ref(&tie)), 4.0, 1e-7);
    assert_area(area(base, &[tie, rectangle([[-1.0, 1.0], [-0.25, 0.25]])]), 4.0 + 1.0 - 2.0 * 0.75, 1e-7);
}

#[test]
fn outlines_that_cross_on_a_curved_surface() {
    let tube = cylinder(&Frame::IDENTITY, 2.0, [FULL, [0.0, 10.0]]);
    // Rectangles of the tube: over quarter turns the plane's coordinate is the angle.
    let quarter = FRAC_PI_2;
    let loops = [
        rectangle([[0.0, 3.0 * quarter], [1.0, 5.0]]),
        rectangle([[quarter, 4.0 * quarter], [3.0, 9.0]]),
        rectangle([[2.0 * quarter, 3.0 * quarter], [3.0, 5.0]]),
    ];
    let cells = 3.0 * 4.0 + 3.0 * 6.0 - 2.0 * (2.0 * 2.0) + 1.0 * 2.0;
    assert_area(area(&tube, &loops), 2.0 * quarter * cells, 1e-7);
}
