//! Points and boxes against random rational loops; the second method sums angles over hulls.

pub use crate::support::random::Random;
use glam::{DVec2, DVec4};
use halfpixel::geometry::BezierCurve;
use halfpixel::model::{Loop, TrimCurve};
use halfpixel::scene::{ParameterBox, Region, Trims};

pub fn curve(points: &[(DVec2, f64)]) -> TrimCurve {
    let points = points.iter().map(|&(p, w)| (p * w).extend(0.0).extend(w)).collect();
    TrimCurve { curve: BezierCurve::new("test", points).expect("a good curve"), gap: 0.0, edge: Some(1) }
}

pub fn polygon(corners: &[[f64; 2]]) -> Loop {
    let next = |k: usize| corners[(k + 1) % corners.len()];
    let line = |k: usize| curve(&[(corners[k].into(), 1.0), (next(k).into(), 1.0)]);
    Loop { curves: (0..corners.len()).map(line).collect() }
}

/// The angle that a curve covers as seen from a point, in turns; `None` where the point is too near to tell.
fn turns(points: &[DVec4], p: DVec2, depth: u32) -> Option<f64> {
    let flat: Vec<DVec2> = points.iter().map(|q| DVec2::new(q.x, q.y) / q.w - p).collect();
    // All of the hull on one side of a line through the point: the angle between the ends is less than half a turn.
    // Coordinates are about 1: what is nearer than their rounding can't be told.
    let apart = |n: DVec2| flat.iter().all(|q| q.dot(n) > 1e-13 * n.length());
    let (a, b) = (flat[0], flat[flat.len() - 1]);
    let middle = flat.iter().sum::<DVec2>();
    if [middle, a, b, a + b, DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y].into_iter().any(apart) {
        return Some(a.angle_to(b) / std::f64::consts::TAU);
    }
    if depth == 40 {
        return None;
    }
    let [low, high] = halves(points);
    Some(turns(&low, p, depth + 1)? + turns(&high, p, depth + 1)?)
}

/// The two halves of a curve by de Casteljau.
fn halves(points: &[DVec4]) -> [Vec<DVec4>; 2] {
    let (mut low, mut high) = (points.to_vec(), points.to_vec());
    for (level, point) in low.iter_mut().enumerate().skip(1) {
        for k in 0..points.len() - level {
            high[k] = (high[k] + high[k + 1]) * 0.5;
        }
        *point = high[0];
    }
    [low, high]
}

fn winds_odd(loops: &[Loop], p: [f64; 2]) -> Option<bool> {
    let mut sum = 0.0;
    for piece in loops.iter().flat_map(|l| &l.curves) {
        sum += turns(piece.curve.points(), p.into(), 0)?;
    }
    assert!((sum - sum.round()).abs() < 1e-6, "{sum}");
    Some(sum.round() as i64 % 2 != 0)
}

/// One to four closed loops of random rational curves up to degree 7, some straight, some along the axes.
pub fn random_loops(random: &mut Random) -> Vec<Loop> {
    let snap = random.below(3) == 0;
    let mut point = |random: &mut Random| {
        let p = DVec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        if snap { (p * 4.0).round() * 0.25 } else { p }
    };
    let count = 1 + random.below(4);
    let mut loops = Vec::new();
    for _ in 0..count {
        let corners: Vec<DVec2> = (0..2 + random.below(6)).map(|_| point(random)).collect();
        let piece = |random: &mut Random, k: usize, point: &mut dyn FnMut(&mut Random) -> DVec2| {
            let degree = 1 + random.below(7);
            let mut points = vec![(corners[k], random.between(0.2, 3.0))];
            (1..degree).for_each(|_| points.push((point(random), random.between(0.2, 3.0))));
            points.push((corners[(k + 1) % corners.len()], random.between(0.2, 3.0)));
            curve(&points)
        };
        loops.push(Loop { curves: (0..corners.len()).map(|k| piece(random, k, &mut point)).collect() });
    }
    loops
}

#[test]
fn points_agree_with_winding_numbers() {
    let mut random = Random(3);
    let (mut told, mut inside) = (0, 0);
    for round in 0..1500 {
        let loops = random_loops(&mut random);
        let mut trims = Trims::default();
        let number = trims.add(&loops);
        let tree = trims.tree(number);
        for k in 0..40 {
            let mut p = [random.between(-1.1, 1.1), random.between(-1.1, 1.1)];
            if k % 4 == 0 {
                // At the height of an end, or next to a curve.
                let curves = &loops[random.below(loops.len())].curves;
                let curve = &curves[random.below(curves.len())].curve;
                let q = curve.position(if k % 8 == 0 { 0.0 } else { random.unit() });
                p = if k % 8 == 0 { [p[0], q.y] } else { [q.x + random.between(-1e-7, 1e-7), q.y] };
            }
            let Some(expected) = winds_odd(&loops, p) else { continue };
            told += 1;
            inside += usize::from(expected);
            assert_eq!(tree.contains(p), expected, "round {round}: {p:?} in {loops:?}");
        }
    }
    assert!(told > 50_000 && inside > told / 10 && inside < told * 9 / 10, "{inside} of {told}");
}

#[test]
fn boxes_say_what_all_their_points_say() {
    let mut random = Random(5);
    let mut counts = [0; 3];
    for _ in 0..1500 {
        let loops = random_loops(&mut random);
        let mut trims = Trims::default();
        let number = trims.add(&loops);
        let tree = trims.tree(number);
        for _ in 0..20 {
            let size = 10f64.powf(random.between(-3.0, 0.0));
            let low = [random.between(-1.1, 1.1), random.between(-1.1, 1.1)];
            let area = ParameterBox { low, high: [low[0] + size * random.unit(), low[1] + size * random.unit()] };
            let region = tree.classify(&area);
            counts[region as usize] += 1;
            let at = |k: usize, share: f64| area.low[k] + (area.high[k] - area.low[k]) * share;
            if region == Region::Boundary {
                // Some curve is there: it is found again by following all of them.
                let meets = loops.iter().flat_map(|l| &l.curves).any(|c| passes(c.curve.points(), &area, 0));
                assert!(meets, "{area:?} in {loops:?}");
                continue;
            }
            for _ in 0..8 {
                let p = [at(0, random.unit()), at(1, random.unit())];
                assert_eq!(tree.contains(p), region == Region::Inside, "{p:?} of {area:?} in {loops:?}");
            }
        }
    }
    assert!(counts.iter().all(|&c| c > 1000), "{counts:?}");
}

/// The curve has a point in the box, or within rounding of it.
fn passes(points: &[DVec4], area: &ParameterBox, depth: u32) -> bool {
    let flat = points.iter().map(|q| [q.x / q.w, q.y / q.w]);
    let hull = flat.fold(ParameterBox::EMPTY, |b, p| b.union(&ParameterBox { low: p, high: p }));
    if !hull.touches(&area.grown([1e-9; 2])) {
        return false;
    }
    if depth == 40 {
        return true;
    }
    let [low, high] = halves(points);
    passes(&low, area, depth + 1) || passes(&high, area, depth + 1)
}

#[test]
fn a_thousand_holes_need_few_tests() {
    // A plate with 40 x 40 square holes, wound as they come.
    let mut loops = vec![polygon(&[[-1.0, -1.0], [41.0, -1.0], [41.0, 41.0], [-1.0, 41.0]])];
    for i in 0..40 {
        for j in 0..40 {
            let (u, v) = (f64::from(i), f64::from(j));
            loops.push(polygon(&[[u, v], [u + 0.5, v], [u + 0.5, v + 0.5], [u, v + 0.5]]));
        }
    }
    let mut trims = Trims::default();
    let number = trims.add(&loops);
    let tree = trims.tree(number);
    for i in 0..80 {
        for j in 0..80 {
            let p = [f64::from(i) * 0.5 + 0.25, f64::from(j) * 0.5 + 0.25];
            assert_eq!(tree.contains(p), i % 2 == 1 || j % 2 == 1, "{p:?}");
            // On a corner: to the right and above decides.
            let p = [f64::from(i) * 0.5, f64::from(j) * 0.5];
            assert_eq!(tree.contains(p), i % 2 == 1 || j % 2 == 1, "{p:?}");
        }
    }
    // 6,404 segments; three cells a hole would be many.
    assert!(trims.bytes() < 6404 * 200, "{} bytes", trims.bytes());
}

#[test]
fn awkward_loops_have_one_answer_everywhere() {
    let square = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    // Coincident twice: nothing is inside. Three times: as once.
    for (copies, inside) in [(1, true), (2, false), (3, true)] {
        let loops = vec![square.clone(); copies];
        let mut trims = Trims::default();
        let number = trims.add(&loops);
        assert_eq!(trims.tree(number).contains([1.0, 1.0]), inside, "{copies} copies");
    }
    // A hole that touches the outer loop in a point and along a side, a zero-length curve, a spike out and back.
    let spike = polygon(&[[0.5, 0.5], [1.0, 0.5], [1.0, 3.0], [1.0, 0.5], [1.5, 0.5], [1.5, 0.5], [1.0, 1.0]]);
    let touching = polygon(&[[0.0, 1.2], [0.5, 1.2], [0.5, 1.6], [0.0, 1.6]]);
    let loops = vec![square, spike, touching];
    let mut trims = Trims::default();
    let number = trims.add(&loops);
    let tree = trims.tree(number);
    for i in 0..200 {
        for j in 0..200 {
            let p = [f64::from(i) * 0.0111 - 0.05, f64::from(j) * 0.0111 - 0.05];
            let Some(expected) = winds_odd(&loops, p) else { continue };
            assert_eq!(tree.contains(p), expected, "{p:?}");
        }
    }
    assert!(!tree.contains([f64::NAN, 1.0]) && !tree.contains([1.0, f64::INFINITY]));
    let nothing = trims.add(&[]);
    assert!(!trims.tree(nothing).contains([0.0, 0.0]));
    assert_eq!(trims.tree(nothing).classify(&ParameterBox { low: [0.0; 2], high: [1.0; 2] }), Region::Outside);
}

#[test]
fn open_loops_are_closed_by_a_line() {
    let mut open = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    open.curves.remove(2);
    let mut trims = Trims::default();
    let number = trims.add(&[open]);
    assert!(trims.tree(number).contains([1.0, 1.0]) && !trims.tree(number).contains([3.0, 1.0]));
}

#[test]
fn moved_lists_answer_alike() {
    let mut random = Random(8);
    let loops: Vec<Vec<Loop>> = (0..20).map(|_| random_loops(&mut random)).collect();
    let mut together = Trims::default();
    for loops in &loops {
        let mut alone = Trims::default();
        alone.add(loops);
        together.append(alone);
    }
    for (k, loops) in loops.iter().enumerate() {
        let mut alone = Trims::default();
        alone.add(loops);
        for _ in 0..200 {
            let p = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
            assert_eq!(together.tree(k as u32).contains(p), alone.tree(0).contains(p));
        }
    }
}

#[test]
fn a_turn_near_an_end_leaves_the_curve_what_it_is() {
    // It rises by a hair, turns and falls: far from the origin, where rounding turns it again.
    for rise in [1e-4, 3e-6, 1e-8, 1e-11] {
        let p = |x: f64, y: f64| (DVec2::new(x, y), 1.0);
        let bow = curve(&[p(-11.76, 29.0), p(-12.29, 29.0 + rise), p(-12.82, 28.962), p(-13.343, 28.886)]);
        let line = |a: [f64; 2], b: [f64; 2]| curve(&[p(a[0], a[1]), p(b[0], b[1])]);
        let (a, b, c, d) = ([-11.76, 29.0], [-13.343, 28.886], [-13.343, -29.0], [-11.76, -29.0]);
        let bow_curve = bow.curve.clone();
        let face = Loop { curves: vec![bow, line(b, c), line(c, d), line(d, a)] };
        let mut trims = Trims::default();
        let tree = trims.add(&[face]);
        for k in 1..200 {
            let q = bow_curve.position(f64::from(k) / 200.0);
            let tree = trims.tree(tree);
            assert!(tree.contains([q.x, q.y - 1e-9]) && !tree.contains([q.x, q.y + 1e-9]), "{rise:e} {q}");
        }
    }
}

#[test]
fn segments_are_handed_down_from_box_to_box() {
    let mut random = Random(23);
    let (mut some, mut none) = (0, 0);
    for _ in 0..200 {
        let corners: Vec<[f64; 2]> = (0..3 + random.below(20)).map(|_| [random.unit(), random.unit()]).collect();
        let mut trims = Trims::default();
        let number = trims.add(&[polygon(&corners)]);
        let tree = trims.tree(number);
        for _ in 0..20 {
            let mut point = || [random.between(-0.2, 1.2), random.between(-0.2, 1.2)];
            let outer = ParameterBox::around([point(), point()]);
            let inside = |t: f64, k: usize| outer.low[k] + (outer.high[k] - outer.low[k]) * t;
            let (a, b) = ([random.unit(), random.unit()], [random.unit(), random.unit()]);
            let inner = ParameterBox::around([a, b].map(|p| [0, 1].map(|k| inside(p[k], k))));
            let (mut of_outer, mut of_inner) = (vec![u32::MAX], Vec::new());
            tree.collect(&outer, &mut of_outer);
            tree.collect(&inner, &mut of_inner);
            // What was in the list stays, and everything else is there once.
            assert_eq!(of_outer.remove(0), u32::MAX);
            assert!(of_outer.is_sorted_by(|a, b| a < b));
            of_outer.retain(|&s| tree.meets(s, &inner));
            assert_eq!(of_outer, of_inner);
            assert_eq!(of_inner.is_empty(), tree.classify(&inner) != Region::Boundary);
            if of_inner.is_empty() { none += 1 } else { some += 1 }
        }
    }
    assert!(some > 500 && none > 500, "{some} {none}");
}
