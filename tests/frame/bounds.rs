//! A bound is never exceeded: random rational patches, drawn with each bound, every pixel checked in f64.

use super::support::*;
use glam::DVec3;
use halfpixel::geometry::BezierPatch;
use halfpixel::scene::{Scene, ViewSpec};
use halfpixel::stages::{Bound, Fill, Grid, Options, Renderer};
use rayon::prelude::*;

const PATCHES: u64 = 1500;

/// Unit roundoff of f64 many times over; far below what the contract could notice.
const SLACK: f64 = 1e-9;

fn patch(random: &mut Random, spread: f64) -> BezierPatch {
    let degree = [(); 2].map(|()| 1 + random.below(7));
    // From a bumpy square to points anywhere.
    let [bump, lift] = [random.between(0.0, 0.6), random.between(0.0, 1.0)];
    let places = (0..=degree[0]).flat_map(|i| (0..=degree[1]).map(move |j| (i, j)));
    let points = places.map(|(i, j)| {
        let w = spread.powf(random.between(-1.0, 1.0));
        let flat =
            DVec3::new(i as f64 / degree[0] as f64, j as f64 / degree[1] as f64, 0.0) - DVec3::new(0.5, 0.5, 0.0);
        let p = flat + random.point(1.0) * DVec3::new(bump, bump, lift);
        (p * w).extend(w)
    });
    BezierPatch::new("random", degree, points.collect()).expect("a good patch")
}

/// A view of a model from outside, or now and then from among its control points.
fn view(random: &mut Random) -> ViewSpec {
    let inside = random.below(5) == 0;
    let eye = if inside { random.point(0.5) } else { random.point(1.0).normalize() * random.between(1.5, 8.0) };
    ViewSpec {
        size: [40, 32],
        orthographic: random.below(2) == 0,
        zoom: if inside { 1.0 } else { 10f64.powf(random.between(-0.5, 2.0)) },
        eye: Some(eye),
        target: Some(random.point(0.4)),
        ..ViewSpec::default()
    }
}

/// Drawn pixels, and those whose interpolated parameter is off by more than half a pixel.
fn count(scene: &Scene, spec: ViewSpec, bound: Bound) -> [u64; 2] {
    let camera = camera(scene, spec);
    let options = Options { bound, fill: Fill::Off, refine: 0, ..Options::default() };
    let frame = render(scene, &camera, &options);
    let mut counts = [0, 0];
    for at in pixels(spec.size) {
        let Some(pixel) = frame.pixel(at[0], at[1]) else { continue };
        let error = error(scene, &camera, at, &pixel, pixel.interpolated);
        counts[0] += 1;
        counts[1] += u64::from(error.is_nan() || error > 0.5 + SLACK);
    }
    counts
}

/// Sums over random patches; `spread(k)` gives the range of weights of patch k.
fn sums(bound: Bound, patches: u64, spread: impl Fn(u64) -> f64 + Sync) -> [u64; 2] {
    let one = |k: u64| {
        let mut random = Random(k);
        let scene = single(patch(&mut random, spread(k)));
        count(&scene, view(&mut random), bound)
    };
    (0..patches).into_par_iter().map(one).reduce(|| [0, 0], |a, b| [a[0] + b[0], a[1] + b[1]])
}

#[test]
fn proved_bounds_hold_on_random_rational_patches() {
    for bound in [Bound::Screen, Bound::Eter, Bound::Filip, Bound::Projective] {
        // Weights 0.1 to 10, some 1e-3 to 1e3, some all alike.
        let spread = |k| match k % 16 {
            0 => 1e3,
            1..4 => 1.0,
            _ => 10.0,
        };
        let [drawn, wrong] = sums(bound, PATCHES, spread);
        assert!(drawn > 200 * PATCHES, "{bound:?} draws only {drawn} pixels");
        assert_eq!(wrong, 0, "{bound:?}: of {drawn} pixels");
    }
}

/// The check above can fail: `slefe` is no guarantee.
#[test]
fn slefe_exceeds_its_tolerance() {
    let [drawn, wrong] = sums(Bound::Slefe, 300, |_| 1.0);
    assert!(wrong > 20, "{wrong} of {drawn}");
}

/// So is reading an affine bound's parameters projectively: the wrong interpolation must not pass either.
#[test]
fn a_larger_tolerance_is_seen() {
    let mut wrong = 0;
    for k in 0..40 {
        let mut random = Random(k);
        let scene = single(patch(&mut random, 10.0));
        let spec = view(&mut random);
        let camera = camera(&scene, spec);
        let options =
            Options { fill: Fill::Off, refine: 0, tolerance: 3.0, depth_tolerance: 8.0, ..Options::default() };
        let frame = render(&scene, &camera, &options);
        let errors = pixels(spec.size).filter_map(|at| {
            frame.pixel(at[0], at[1]).map(|pixel| error(&scene, &camera, at, &pixel, pixel.interpolated))
        });
        wrong += errors.filter(|e| *e > 0.5).count();
    }
    assert!(wrong > 100, "{wrong}");
}

/// A flat patch most of which lies within a millionth of v = 1: too little for one grid's f32 parameters.
#[test]
fn parameters_of_steep_weights_stay_exact_enough() {
    let weights = [1e3, 1e-3];
    let corner = |k: usize| (DVec3::new((k / 2) as f64, (k % 2) as f64, 0.0) * weights[k % 2]).extend(weights[k % 2]);
    let patch = BezierPatch::new("steep", [1, 1], (0..4).map(corner).collect()).expect("a good patch");
    let scene = single(patch);
    for bound in [Bound::Screen, Bound::Filip, Bound::Projective] {
        let [drawn, wrong] = count(&scene, ViewSpec { size: [640, 480], ..ViewSpec::default() }, bound);
        assert!(drawn > 10_000 && wrong == 0, "{bound:?}: {wrong} of {drawn}");
    }
}

/// ETER's equation (2): triangles of `Grid::Eter16` fit 16 x 16 pixels, whatever the weights and the view; some come near that.
#[test]
fn small_triangles_fit_their_boxes() {
    let largest = (0..300u64).into_par_iter().map(|seed| {
        let mut random = Random(seed);
        let scene = single(patch(&mut random, if seed % 2 == 0 { 1.0 } else { 10.0 }));
        let camera = camera(&scene, view(&mut random));
        // A tolerance that asks for next to nothing by itself.
        let options = Options {
            bound: Bound::Eter,
            grid: Grid::Eter16,
            tolerance: 1e3,
            depth_tolerance: 1e6,
            ..Options::default()
        };
        let (staged, vertices) = Renderer::new(&scene).staged(&camera, &options).expect("grids");
        let sides = staged.meshlets.iter().flat_map(|m| {
            let across = usize::from(m.quads[1]) + 1;
            let at = move |i: usize, j: usize| m.vertices as usize + i * across + j;
            let quads = (0..usize::from(m.quads[0])).flat_map(move |i| (0..across - 1).map(move |j| (i, j)));
            quads.map(move |(i, j)| [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)])
        });
        let side = sides.map(|quad| {
            let all = quad.map(|k| [vertices[k].x, vertices[k].y]);
            let span = |axis: usize| {
                let places = all.map(|p| p[axis]);
                places.iter().max().expect("four") - places.iter().min().expect("four")
            };
            f64::from(span(0).max(span(1))) / 256.0
        });
        side.fold(0.0, f64::max)
    });
    let largest = largest.reduce(|| 0.0, f64::max);
    println!("the largest triangle is {largest} pixels wide");
    assert!((4.0..=16.0 + 2.0 / 256.0).contains(&largest), "{largest}");
}
