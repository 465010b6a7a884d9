//! Trimmed frames against pictures that are known exactly: rays through solids by formula.

use crate::tree::Random;
use glam::{DVec2, DVec3};
use halfpixel::import::builtin::builtin;
use halfpixel::model::SurfaceKind;
use halfpixel::scene::{Camera, Projection, Scene, View, ViewSpec, prepare};
use halfpixel::stages::{Fill, Frame, Options, Renderer, Trim};
use halfpixel::verify::{Sampling, verify};

/// Pixels by which a trim may be off: what refinement and f32 leave.
const SHARP: f64 = 0.02;

fn scene(name: &str) -> Scene {
    prepare(&builtin(name).expect(name), &|_, _| {}).expect(name)
}

fn draw(scene: &Scene, spec: ViewSpec, options: &Options) -> Frame {
    let camera = spec.camera(&scene.bounds).expect("a camera");
    Renderer::new(scene).render(&camera, options).expect("a frame")
}

/// Origin and direction of the ray through an image point.
fn ray(camera: &Camera, at: DVec2) -> (DVec3, DVec3) {
    let c = at - DVec2::new(f64::from(camera.size[0]), f64::from(camera.size[1])) * 0.5;
    match camera.projection {
        Projection::Perspective { focal } => {
            (camera.eye, camera.forward + (camera.right * c.x + camera.down * c.y) / focal)
        }
        Projection::Orthographic { scale } => {
            (camera.eye + (camera.right * c.x + camera.down * c.y) / scale, camera.forward)
        }
    }
}

/// The face of a solid that a ray meets first, by its number; `None`: it misses.
type Solid = fn(DVec3, DVec3) -> Option<u32>;

fn within([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a.max(c), b.min(d)]
}

/// Where a ray is inside the unit-like cylinder about z.
fn cylinder(o: DVec3, d: DVec3, radius: f64) -> Option<[f64; 2]> {
    let (a, b) = (d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y);
    let c = o.x * o.x + o.y * o.y - radius * radius;
    if a == 0.0 {
        return (c < 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let root = (b * b - a * c).sqrt();
    (root > 0.0).then(|| [(-b - root) / a, (-b + root) / a])
}

/// Where a ray is on the side of a plane where `n . p <= offset`.
fn half_space(o: DVec3, d: DVec3, n: DVec3, offset: f64) -> [f64; 2] {
    let (distance, slope) = (offset - n.dot(o), n.dot(d));
    match slope {
        s if s > 0.0 => [f64::NEG_INFINITY, distance / s],
        s if s < 0.0 => [distance / s, f64::INFINITY],
        _ if distance >= 0.0 => [f64::NEG_INFINITY, f64::INFINITY],
        _ => [1.0, 0.0],
    }
}

fn wedge(o: DVec3, d: DVec3) -> Option<u32> {
    let round = cylinder(o, d, 1.0)?;
    let top = half_space(o, d, DVec3::new(-0.5, 0.0, 1.0), 0.5);
    let bottom = half_space(o, d, -DVec3::Z, 1.0);
    let inside = within(round, within(top, bottom));
    let face = [(round, 1), (top, 2), (bottom, 3)].into_iter().find(|(range, _)| range[0] == inside[0]);
    if inside[0] < inside[1] { face.map(|(_, face)| face) } else { None }
}

fn drilled(o: DVec3, d: DVec3) -> Option<u32> {
    let sides = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let ranges = sides.map(|n| half_space(o, d, n, 1.0));
    let cube = ranges.into_iter().fold([f64::NEG_INFINITY, f64::INFINITY], within);
    if cube[0] >= cube[1] {
        return None;
    }
    let face = ranges.iter().position(|r| r[0] == cube[0]).map(|k| k as u32 + 1);
    match cylinder(o, d, 0.6) {
        Some(bore) if bore[0] <= cube[0] && bore[1] > cube[0] => (bore[1] < cube[1]).then_some(7),
        _ => face,
    }
}

/// Edges to look at where a view is magnified.
const WEDGE_EDGE: DVec3 =
    DVec3::new(std::f64::consts::FRAC_1_SQRT_2, -std::f64::consts::FRAC_1_SQRT_2, 0.8535533905932737);
const DRILLED_EDGE: DVec3 = DVec3::new(-0.424_264_068_711_928_5, 0.424_264_068_711_928_5, 1.0);

fn spec(view: View, zoom: f64, target: DVec3, orthographic: bool) -> ViewSpec {
    ViewSpec { size: [160, 120], view, zoom, target: Some(target), orthographic, ..ViewSpec::default() }
}

/// All points of a pixel's square, or of one `reach` pixels to each side of its centre, as far as 5 x 5 can tell.
fn around(camera: &Camera, [x, y]: [u32; 2], reach: f64, solid: Solid) -> Vec<Option<u32>> {
    let at = |k: i32| f64::from(k) * 0.5 * reach;
    let mut faces = Vec::new();
    for k in 0..25 {
        let p = DVec2::new(f64::from(x) + 0.5 + at(k % 5 - 2), f64::from(y) + 0.5 + at(k / 5 - 2));
        let (o, d) = ray(camera, p);
        faces.push(solid(o, d));
    }
    faces
}

#[test]
fn solids_have_no_background_inside_and_nothing_beyond() {
    for (name, solid, edge) in [("wedge", wedge as Solid, WEDGE_EDGE), ("drilled", drilled, DRILLED_EDGE)] {
        let scene = scene(&format!("trimmed:{name}"));
        for view in View::ALL {
            for (zoom, orthographic) in [(1.0, false), (1.0, true), (8.0, false), (64.0, true), (1e5, false)] {
                let frame = draw(&scene, spec(view, zoom, edge, orthographic), &Options::default());
                for y in 0..120 {
                    for x in 0..160 {
                        let shown = frame.pixel(x, y).is_some();
                        let seen = around(&frame.camera, [x, y], 0.5, solid);
                        let place = format!("{name} {view:?} {zoom} pixel {x},{y}");
                        assert!(shown || seen.iter().any(Option::is_none), "{place} is background");
                        assert!(!shown || seen.iter().any(Option::is_some), "{place} is not background");
                    }
                }
            }
        }
    }
}

#[test]
fn faces_meet_where_the_exact_edge_runs() {
    // The slanted edge is cut from both sides: cylinder and plane must change over within rounding.
    let scene = scene("trimmed:wedge");
    let mut near = 0;
    for (view, zoom) in [(View::Iso, 1.0), (View::Iso, 8.0), (View::Front, 3.0), (View::Iso, 1e4), (View::Right, 20.0)]
    {
        let frame = draw(&scene, spec(view, zoom, WEDGE_EDGE, false), &Options::default());
        for y in 0..120 {
            for x in 0..160 {
                let seen = around(&frame.camera, [x, y], SHARP, wedge);
                near += usize::from(seen.iter().any(|f| *f != seen[12]));
                // Silhouettes and the rim at the bottom keep half a pixel: only these two faces are told apart.
                let pair = around(&frame.camera, [x, y], 0.6, wedge).iter().all(|f| matches!(f, Some(1 | 2)));
                if !pair || seen.iter().any(|f| *f != seen[12]) {
                    continue;
                }
                let face = frame.pixel(x, y).map(|p| scene.faces[scene.patches[p.patch as usize].face as usize].id);
                assert_eq!(face, seen[12], "{view:?} {zoom} pixel {x},{y}");
            }
        }
    }
    assert!(near > 20, "the edge is in the pictures: {near}");
}

#[test]
fn holes_are_sharp_on_a_plate() {
    let scene = scene("trimmed:plate");
    let hole = |p: DVec2, i: i32, j: i32, radii: DVec2| {
        let center = DVec2::new(0.25 * f64::from(i) - 1.375, 0.25 * f64::from(j) - 0.875);
        ((p - center) / radii).length() < 1.0
    };
    let inside = |p: DVec2| {
        let mut odd = p.x.abs() < 1.5 && p.y.abs() < 1.0;
        for (i, j) in (0..12).flat_map(|i| (0..8).map(move |j| (i, j))) {
            odd ^= hole(p, i, j, DVec2::splat(0.1));
            odd ^= (i + j) % 3 > 0 && hole(p, i, j, DVec2::new(0.06, 0.03 + 0.002 * f64::from(i)));
        }
        odd
    };
    for (view, zoom, orthographic) in
        [(View::Top, 1.0, true), (View::Iso, 1.0, false), (View::Iso, 7.0, false), (View::Bottom, 40.0, false)]
    {
        let target = if zoom > 10.0 { DVec3::new(0.225, 0.125, 0.0) } else { DVec3::ZERO };
        let size = [320, 240];
        let frame = draw(&scene, ViewSpec { size, ..spec(view, zoom, target, orthographic) }, &Options::default());
        let (mut drawn, mut background) = (0, 0);
        for (x, y) in (0..240).flat_map(|y| (0..320).map(move |x| (x, y))) {
            let at = |dx: f64, dy: f64| {
                let (o, d) = ray(&frame.camera, DVec2::new(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy));
                (o - d * (o.z / d.z)).truncate()
            };
            let p = at(0.0, 0.0);
            let expected = inside(p);
            let edge = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
            let unsure = edge.iter().any(|&(dx, dy)| inside(at(SHARP * dx, SHARP * dy)) != expected)
                // The plate's own border is a patch border.
                || edge.iter().any(|&(dx, dy)| at(0.6 * dx, 0.6 * dy).abs().cmpge(DVec2::new(1.5, 1.0)).any());
            let shown = frame.pixel(x, y).is_some();
            drawn += usize::from(shown);
            background += usize::from(!shown);
            assert!(unsure || shown == expected, "{view:?} {zoom} pixel {x},{y} at {p}");
        }
        assert!(drawn > 1000 && background > 1000, "{view:?}: {drawn} {background}");
    }
}

#[test]
fn gaps_of_less_than_a_pixel_are_closed() {
    let scene = scene("trimmed:gap");
    // 0.002 units: 0.04, 0.3 and 0.9 pixels. Nothing behind the plate may shine through its edge.
    for zoom in [1.0, 8.0, 24.0] {
        let frame = draw(&scene, spec(View::Iso, zoom, DRILLED_EDGE, false), &Options::default());
        for (x, y) in (0..120).flat_map(|y| (0..160).map(move |x| (x, y))) {
            let exact = around(&frame.camera, [x, y], 0.5, drilled);
            let shown = frame.pixel(x, y).map(|p| scene.faces[scene.patches[p.patch as usize].face as usize].id);
            assert!(shown.is_some() || exact.iter().any(Option::is_none), "{zoom}: {x},{y} is background");
            let top_and_bore = exact.iter().all(|f| matches!(f, Some(5 | 7)));
            assert!(!top_and_bore || matches!(shown, Some(5 | 7)), "{zoom}: {x},{y} shows {shown:?}");
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    for (name, fill, refine) in [
        ("ball", Fill::Stroke, 2),
        ("touching", Fill::Stroke, 0),
        ("wedge", Fill::Eter, 2),
        ("degree22", Fill::Stroke, 2),
    ] {
        let scene = scene(&format!("trimmed:{name}"));
        let mut frames = Vec::new();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let options = Options { fill, refine, ..Options::default() };
            let spec = ViewSpec { size: [200, 150], ..ViewSpec::default() };
            let frame = pool.install(|| draw(&scene, spec, &options));
            let pixels = (0..150).flat_map(|y| (0..200).map(move |x| (x, y)));
            let pixels: Vec<_> = pixels
                .map(|(x, y)| (frame.word(x, y), frame.pixel(x, y), frame.color(x, y).map(f32::to_bits)))
                .collect();
            frames.push((pixels, frame.stats.trim));
        }
        assert!(frames[0] == frames[1] && frames[0] == frames[2], "{name}");
    }
}

#[test]
fn the_oracle_agrees_everywhere() {
    let mut random = Random(7);
    for name in ["plate", "wedge", "drilled", "ball", "bowl", "degree22", "touching"] {
        let scene = scene(&format!("trimmed:{name}"));
        for view in View::ALL {
            let zoom = 10f64.powf(random.between(0.0, 2.0));
            let target = scene.bounds.low + (scene.bounds.high - scene.bounds.low) * random.unit();
            let frame = draw(&scene, spec(view, zoom, target, random.below(2) == 0), &Options::default());
            let pixels = |x, y| frame.pixel(x, y);
            let sampling = Sampling { samples: Some(300), seed: 1 };
            let report = verify(&scene, &frame.camera, &frame.options, &pixels, &sampling, &|_, _| ());
            let broken = [report.violations, report.cracks, report.covering_failures, report.depth_failures];
            assert_eq!(broken, [0; 4], "{name} {view:?} zoom {zoom} {target}");
        }
    }
}

#[test]
fn whole_faces_meet_cut_ones() {
    // The bore's loops run along its borders: without them it is the same face. The cube's are cut exactly, its own
    // grid only keeps within half a pixel of the edge.
    let mut model = builtin("trimmed:drilled").expect("a built-in");
    for face in model.parts[0].faces.iter_mut().filter(|face| face.kind == SurfaceKind::Cylinder) {
        face.loops = [].into();
    }
    let scene = prepare(&model, &|_, _| {}).expect("a scene");
    for (view, zoom) in [(View::Top, 1.0), (View::Top, 2.0), (View::Bottom, 3.0), (View::Iso, 1.5)] {
        let spec = ViewSpec { size: [240, 180], view, zoom, ..ViewSpec::default() };
        let frame = draw(&scene, spec, &Options::default());
        let pixels = |x, y| frame.pixel(x, y);
        let report = verify(&scene, &frame.camera, &frame.options, &pixels, &Sampling::default(), &|_, _| ());
        let broken = [report.violations, report.cracks, report.covering_failures, report.depth_failures];
        assert_eq!(broken, [0; 4], "{view:?} zoom {zoom}: {:?}", report.worst);
    }
}

#[test]
fn other_ways_to_trim_are_near_the_exact_one() {
    for name in ["plate", "wedge", "ball"] {
        let scene = scene(&format!("trimmed:{name}"));
        let spec = ViewSpec { size: [320, 240], ..ViewSpec::default() };
        let exact = draw(&scene, spec, &Options::default());
        for options in [
            Options { trim: Trim::Texture, ..Options::default() },
            Options { refine: 0, ..Options::default() },
            Options { fill: Fill::Eter, ..Options::default() },
            Options { fill: Fill::Conservative, ..Options::default() },
        ] {
            let frame = draw(&scene, spec, &options);
            // Where the exact picture's neighbourhood is all surface or all background, so is this one.
            for (x, y) in (2..238).flat_map(|y| (2..318).map(move |x| (x, y))) {
                let here = exact.pixel(x, y).is_some();
                let all = (0..25).all(|k| exact.pixel(x + k % 5 - 2, y + k / 5 - 2).is_some() == here);
                let shown = frame.pixel(x, y).is_some();
                assert!(!all || shown == here, "{name} {:?} {:?} {x},{y}", options.trim, options.fill);
            }
        }
        let whole = draw(&scene, spec, &Options { trim: Trim::Off, ..Options::default() });
        assert!(whole.stats.drawn > exact.stats.drawn, "{name}");
        assert_eq!(whole.stats.trim, halfpixel::stages::TrimCounts::default());
    }
}

#[test]
fn prepare_drops_what_lies_outside() {
    // The bowl is half a sphere, cut where patches meet: four patches go, and nothing is left to test.
    let bowl = scene("trimmed:bowl");
    assert_eq!((bowl.patches.len(), bowl.trim_bytes()), (4, 0));
    assert!(bowl.patches.iter().all(|p| p.trim.tree.is_none() && p.trim.rim));
    let drilled = scene("trimmed:drilled");
    assert_eq!(drilled.patches.iter().filter(|p| p.trim.tree.is_some()).count(), 2);
    assert!(drilled.trim_bytes() > 0);
}
