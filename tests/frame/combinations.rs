//! Every combination of bound, grid, fill and projection before the oracle.

use super::support::*;
use halfpixel::scene::ViewSpec;
use halfpixel::stages::{Bound, Fill, Grid, Options};
use halfpixel::verify::{Report, Sampling, verify};

fn report(name: &str, spec: ViewSpec, options: &Options, samples: Option<usize>) -> Report {
    let scene = scene(name);
    let camera = camera(&scene, spec);
    let frame = render(&scene, &camera, options);
    verify(&scene, &camera, options, &|x, y| frame.pixel(x, y), &Sampling { samples, seed: 1 }, &|_, _| {})
}

#[test]
fn proved_bounds_keep_half_a_pixel_whatever_else_is_chosen() {
    for bound in [Bound::Screen, Bound::Eter, Bound::Filip, Bound::Projective] {
        for grid in [Grid::Adaptive, Grid::Variable, Grid::Eter] {
            for fill in [Fill::Stroke, Fill::Eter, Fill::Conservative, Fill::Off] {
                for orthographic in [false, true] {
                    let spec = ViewSpec { size: [160, 120], orthographic, ..ViewSpec::default() };
                    let options = Options { bound, grid, fill, ..Options::default() };
                    for name in ["teapot", "torus"] {
                        let found = report(name, spec, &options, Some(250));
                        let what = format!("{name}, {bound:?}, {grid:?}, {fill:?}, orthographic {orthographic}");
                        assert!(found.drawn > 100, "{what}: nothing drawn");
                        let grid_error = found.grid_error_px.map_or(0.0, |e| e.max);
                        assert!(grid_error <= 0.5, "{what}: {grid_error} px");
                        // Cracks and what fills them are promised for strokes alone; the others are there to compare.
                        let kept = found.violations == 0 && found.cracks == 0;
                        assert!(kept || fill != Fill::Stroke, "{what}: {:?}", found.worst);
                    }
                }
            }
        }
    }
}

#[test]
fn halved_leaves_need_fewer_quads_and_keep_half_a_pixel() {
    for bound in [Bound::Screen, Bound::Eter, Bound::Filip, Bound::Projective] {
        let [mut halved, mut whole] = [0; 2];
        for (name, zoom) in [("teapot", 1.0), ("teapot", 8.0), ("teapot", 64.0), ("torus", 8.0)] {
            let spec = ViewSpec { size: [640, 480], zoom, ..ViewSpec::default() };
            let options = Options { bound, grid: Grid::Adaptive, ..Options::default() };
            let scene = scene(name);
            let camera = camera(&scene, spec);
            let [adaptive, variable] =
                [options, Options { grid: Grid::Variable, ..options }].map(|o| render(&scene, &camera, &o).stats.quads);
            assert!(
                adaptive <= variable,
                "{name}, {bound:?}, zoom {zoom}: {adaptive} quads, {variable} without halving"
            );
            halved += adaptive;
            whole += variable;
            let found = report(name, spec, &options, Some(4000));
            let what = format!("{name}, {bound:?}, zoom {zoom}: {:?}", found.worst);
            assert_eq!((found.violations, found.cracks), (0, 0), "{what}");
            assert!(found.grid_error_px.is_some_and(|e| e.max <= 0.5), "{what}");
        }
        assert!(2 * halved < whole, "{bound:?}: {halved} of {whole} quads");
    }
}

#[test]
fn strokes_close_the_cracks_that_no_filling_leaves() {
    let mut open = 0;
    for zoom in [1.0, 8.0] {
        let spec = ViewSpec { size: [640, 480], zoom, ..ViewSpec::default() };
        open += report("teapot", spec, &Options { fill: Fill::Off, ..Options::default() }, None).cracks;
        let closed = report("teapot", spec, &Options::default(), None);
        assert_eq!(closed.cracks, 0, "zoom {zoom}: {:?}", closed.worst);
        assert_eq!(closed.violations, 0, "zoom {zoom}: {:?}", closed.worst);
    }
    assert!(open > 5, "the teapot's cracks are not seen: {open}");
}

#[test]
fn the_oracle_sees_that_slefe_breaks_the_contract() {
    let spec = ViewSpec { size: [320, 240], ..ViewSpec::default() };
    let found = report("teapot", spec, &Options { bound: Bound::Slefe, ..Options::default() }, Some(2000));
    assert!(found.violations > 10, "{}", found.violations);
}
