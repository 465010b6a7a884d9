//! Trimmed faces against closed forms, and frames of them broken on purpose.

use crate::frames::{Picture, failures};
use crate::shapes::{self, Part, Random};
use glam::{DVec2, DVec3, DVec4};
use halfpixel::geometry::BezierCurve;
use halfpixel::model::{Loop, TrimCurve};
use halfpixel::scene::Scene;
use halfpixel::stages::Pixel;
use halfpixel::verify::Oracle;

fn trim(points: Vec<DVec4>, gap: f64, edge: Option<u32>) -> TrimCurve {
    TrimCurve { curve: BezierCurve::new("test", points).unwrap(), gap, edge }
}

/// A circle in the plane, of four rational quadratics.
fn circle(center: DVec2, radius: f64) -> Loop {
    let w = 0.5_f64.sqrt();
    let corner = |k: usize| {
        let angle = k as f64 * std::f64::consts::FRAC_PI_4;
        let (reach, w) = if k % 2 == 1 { (radius / w, w) } else { (radius, 1.0) };
        let p = center + DVec2::from_angle(angle) * reach;
        DVec4::new(p.x * w, p.y * w, 0.0, w)
    };
    Loop { curves: (0..4).map(|k| trim((2 * k..2 * k + 3).map(corner).collect(), 0.0, Some(k as u32))).collect() }
}

/// A rectangle in the plane; its sides from the lower one, each with its gap and edge.
fn rectangle(low: DVec2, high: DVec2, sides: [(f64, Option<u32>); 4]) -> Loop {
    let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)].map(|p| p.extend(0.0).extend(1.0));
    let side = |k: usize| trim(vec![corners[k], corners[(k + 1) % 4]], sides[k].0, sides[k].1);
    Loop { curves: (0..4).map(side).collect() }
}

/// A square of side 8 that faces the camera at this depth; its plane's coordinates are those of the world (x, z).
fn wall(depth: f64, face: u32) -> Part {
    shapes::plane(DVec3::new(-4.0, depth, -4.0), DVec3::X * 8.0, DVec3::Z * 8.0, face)
}

/// Walls with these loops, at depths 0, 1, ...
fn walls(loops: Vec<Vec<Loop>>) -> Scene {
    let parts: Vec<Part> = (0..loops.len()).map(|k| wall(k as f64, k as u32)).collect();
    let mut scene = shapes::scene(&parts, DVec3::ZERO);
    for patch in &mut scene.patches {
        patch.domain = [[-4.0, 4.0]; 2];
    }
    for (face, loops) in scene.faces.iter_mut().zip(loops) {
        face.loops = loops.into();
    }
    scene
}

fn ring() -> Vec<Loop> {
    vec![circle(DVec2::ZERO, 3.0), circle(DVec2::new(0.5, 0.0), 1.5)]
}

/// Ten pixels a unit; (0, 0) is the corner of four pixels.
fn picture(scene: Scene) -> Picture {
    Picture::perfect(scene, shapes::front([100, 100], 10.0))
}

#[test]
fn ring_is_hit_between_its_circles() {
    for orthographic in [false, true] {
        let scene = walls(vec![ring()]);
        let camera = shapes::camera(&scene, [400, 300], orthographic);
        let oracle = Oracle::new(&scene, &camera);
        let mut random = Random(3);
        let mut met = 0;
        for _ in 0..20_000 {
            let (x, y) = (random.unit() * 400.0, random.unit() * 300.0);
            let (o, d) = shapes::ray(&camera, x, y);
            let at = o - d * (o.y / d.y);
            let outside = [DVec2::new(at.x, at.z).length() - 3.0, 1.5 - DVec2::new(at.x - 0.5, at.z).length()];
            let outside = outside[0].max(outside[1]);
            let hits = oracle.hits(x, y);
            if outside.abs() < 1e-5 {
                continue;
            }
            assert_eq!(hits.len(), usize::from(outside < 0.0), "({x}, {y}): {outside}, {hits:?}");
            met += hits.len();
        }
        assert!(met > 1000, "{met}");
    }
}

#[test]
fn trims_are_closed_to_the_resolution() {
    let scene = walls(vec![ring()]);
    let oracle = Oracle::new(&scene, &shapes::front([100, 100], 10.0));
    for k in 0..500 {
        let direction = DVec2::from_angle(f64::from(k) * 0.01257);
        let hits = |radius: f64| {
            let p = DVec2::splat(50.0) + direction * (10.0 * radius);
            oracle.hits(p.x, p.y).len()
        };
        assert_eq!([hits(3.0 - 1e-4), hits(3.0), hits(3.0 + 8e-6), hits(3.0 + 2e-5)], [1, 1, 1, 0], "{k}");
    }
}

#[test]
fn a_picture_of_a_ring_passes_and_what_is_broken_is_caught() {
    let mut good = picture(walls(vec![ring()]));
    assert!(good.report().passed(), "{:?}", good.report().worst);
    let drawn = good.report().drawn as f64;
    let exact = std::f64::consts::PI * (9.0 - 2.25) * 100.0;
    assert!((drawn / exact - 1.0).abs() < 0.01, "{drawn} pixels of {exact}");
    // A hole in the ring; a pixel of the hole that is drawn.
    *good.at(30, 50) = None;
    let shown = Pixel { stored: [0.555, 0.505], ..good.at(70, 50).unwrap() };
    *good.at(54, 49) = Some(Pixel { interpolated: shown.stored, ..on_wall(shown, 54, 49) });
    let report = good.report();
    assert_eq!(failures(&report), [0, 1, 1, 0], "{:?}", report.worst);
}

/// A pixel of the walls that shows its centre.
fn on_wall(pixel: Pixel, x: u32, y: u32) -> Pixel {
    let at = [(f64::from(x) + 0.5 - 10.0) / 80.0, (90.0 - f64::from(y) - 0.5) / 80.0];
    Pixel { stored: at, interpolated: at, ..pixel }
}

#[test]
fn a_filled_hole_is_caught_in_every_pixel_but_the_rims() {
    let mut good = picture(walls(vec![ring(), vec![]]));
    assert!(good.report().passed(), "{:?}", good.report().worst);
    let ring = good.at(30, 50).unwrap();
    let mut filled = 0;
    for (y, x) in (0..100).flat_map(|y| (0..100).map(move |x| (y, x))) {
        let at = DVec2::new(f64::from(x) + 0.5 - 55.0, f64::from(y) + 0.5 - 50.0);
        if at.length() < 13.9 {
            *good.at(x, y) = Some(on_wall(ring, x, y));
            filled += 1;
        }
    }
    let report = good.report();
    assert_eq!(failures(&report), [0, 0, filled, 0], "{:?}", report.worst);
}

#[test]
fn a_hole_is_not_filled_by_the_far_side_of_its_own_face() {
    // A tube across the view; a round hole in its near wall shows the far one.
    let quarter = shapes::cylinder();
    let mut scene = shapes::scene(&quarter, DVec3::ZERO);
    for (k, patch) in scene.patches.iter_mut().enumerate() {
        patch.domain = [[k as f64, k as f64 + 1.0], [-1.0, 1.0]];
    }
    let whole = rectangle(DVec2::new(0.0, -1.0), DVec2::new(4.0, 1.0), [(0.0, None); 4]);
    scene.faces[0].loops = [whole, circle(DVec2::new(3.0, 0.0), 0.5)].into();
    let mut good = Picture::perfect(scene, shapes::front([100, 100], 40.0));
    assert!(good.report().passed(), "{:?}", good.report().worst);
    // Quarter 3 begins where x is 0 and y is -1: nearest to the eye.
    let far = *good.at(50, 50);
    assert!(far.is_some_and(|p| p.patch < 2), "the hole shows the far wall: {far:?}");
    let near = Pixel { patch: 3, stored: [0.0, 0.5], depth: far.unwrap().depth + 0.01, ..far.unwrap() };
    *good.at(50, 50) = Some(Pixel { interpolated: near.stored, ..near });
    assert_eq!(failures(&good.report())[2], 1, "{:?}", good.report().worst);
}

/// Two faces left and right of a hole `width` wide about x = 0.05, a column of pixel centres, with these gaps, on
/// surfaces that go on beyond (or end at) their trims; behind them nothing or a third face.
fn halves(width: f64, gap: f64, ends: bool, behind: bool, shared: bool) -> Picture {
    let (low, high) = (DVec2::splat(-3.0), DVec2::splat(3.0));
    let at = [0.05 - 0.5 * width, 0.05 + 0.5 * width];
    let no = (0.0, None);
    let left = rectangle(low, DVec2::new(at[0], high.y), [no, (gap, Some(7)), no, no]);
    let right = rectangle(DVec2::new(at[1], low.y), high, [no, no, no, (gap, Some(if shared { 7 } else { 8 }))]);
    let mut loops = vec![vec![left], vec![right]];
    if behind {
        loops.push(vec![]);
    }
    let mut scene = walls(loops);
    if ends {
        // The patch is the loop's own rectangle.
        for (k, range) in [[-3.0, at[0]], [at[1], 3.0]].into_iter().enumerate() {
            let corner = DVec3::new(range[0], k as f64, -3.0);
            let part = shapes::plane(corner, DVec3::X * (range[1] - range[0]), DVec3::Z * 6.0, k as u32);
            scene.patches[k].domain = [range, [-3.0, 3.0]];
            scene.patches[k].origin = corner;
            let points = scene.patches[k].points.clone();
            let local = part.points.iter().map(|q| (q.truncate() - corner).extend(1.0));
            scene.points[points].iter_mut().zip(local).for_each(|(to, from)| *to = from);
        }
    }
    picture(scene)
}

#[test]
fn a_crack_along_an_edge_is_caught_up_to_the_gap() {
    for (ends, behind) in [(false, false), (false, true), (true, false), (true, true)] {
        // The hole is 0.4 px wide and the measured gap closes it; seen through it: 60 pixels, and what is behind shows.
        let seen_through = [0, 60, 0, if behind { 60 } else { 0 }];
        let mut open = halves(0.04, 0.02, ends, behind, true);
        let report = open.report();
        assert_eq!(failures(&report), seen_through, "{ends} {behind}: {:?}", report.worst);
        // Drawn as a stroke along the trim of the left face: right.
        let neighbour = open.at(49, 50).unwrap();
        let end = if ends { 1.0 } else { (0.03 + 4.0) / 8.0 };
        for y in 20..80 {
            let stored = [end, open.at(49, y).unwrap().stored[1]];
            *open.at(50, y) = Some(Pixel { stored, interpolated: stored, filled: true, ..neighbour });
        }
        assert!(open.report().passed(), "{:?}", open.report().worst);
        // The model has this hole: no gap was measured, or the edges are not the same.
        assert!(halves(0.04, 0.0, ends, behind, true).report().passed());
        assert!(halves(0.04, 0.02, ends, behind, false).report().passed());
        // Wider than a pixel: may be shown.
        assert!(halves(0.5, 0.25, ends, behind, true).report().passed());
        assert_eq!(failures(&halves(0.099, 0.25, ends, behind, true).report()), seen_through);
    }
}

#[test]
fn a_neighbour_in_the_reach_of_a_face_may_be_shown() {
    // Large gaps on faces that meet exactly: the exact picture is right, and so is one shifted by a third of a pixel.
    let mut exact = halves(0.0, 0.05, false, false, true);
    assert!(exact.report().passed(), "{:?}", exact.report().worst);
    let left = exact.at(49, 50).unwrap();
    *exact.at(50, 50) = Some(on_wall(left, 50, 50));
    assert!(exact.report().passed(), "{:?}", exact.report().worst);
    *exact.at(52, 50) = Some(on_wall(left, 52, 50));
    assert_eq!(failures(&exact.report()), [0, 0, 1, 0], "{:?}", exact.report().worst);
}

/// A wall goes steeply back behind another from an edge that lies on it: nothing of it but that edge is in sight.
/// Refinement may end this many pixels beside the edge.
#[test]
fn of_a_hidden_face_its_edge_may_be_shown_but_not_what_lies_beside_it() {
    for (beside, covering) in [(0.003, 0), (0.03, 1)] {
        let edge = 0.45 - 0.1 * beside;
        let steep = shapes::plane(DVec3::new(edge + 0.08, -4.0, -4.0), DVec3::new(-0.16, 8.0, 0.0), DVec3::Z * 8.0, 1);
        let mut scene = shapes::scene(&[wall(0.0, 0), steep], DVec3::ZERO);
        for patch in &mut scene.patches {
            patch.domain = [[-4.0, 4.0]; 2];
        }
        let sides = [(0.0, None), (0.0, None), (0.0, None), (0.0, Some(7))];
        scene.faces[1].loops = vec![rectangle(DVec2::new(0.0, -3.0), DVec2::new(4.0, 3.0), sides)].into();
        let mut picture = picture(scene);
        assert!(picture.report().passed(), "{:?}", picture.report().worst);
        let shown = picture.at(54, 49).unwrap();
        let at = [(edge + 0.08 - 0.45) / 0.16, 40.5 / 80.0];
        *picture.at(54, 49) = Some(Pixel { patch: 1, stored: at, interpolated: at, ..shown });
        assert_eq!(failures(&picture.report()), [0, 0, covering, 0], "{beside}: {:?}", picture.report().worst);
    }
}
