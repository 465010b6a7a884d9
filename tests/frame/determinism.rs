//! The same input gives the same bits on any number of threads.

use super::support::*;
use halfpixel::scene::ViewSpec;
use halfpixel::stages::{Bound, Fill, Grid, Options, Renderer};
use rayon::ThreadPoolBuilder;

#[test]
fn one_two_and_five_threads_draw_the_same_bits() {
    let eter = Options { bound: Bound::Eter, grid: Grid::Eter, fill: Fill::Eter, ..Options::default() };
    let views = [("teapot", 1.0), ("sphere", 30.0), ("stress", 1.0), ("stress:room", 2.0)];
    for ((name, zoom), options) in views.into_iter().flat_map(|v| [(v, Options::default()), (v, eter)]) {
        let scene = scene(name);
        let camera = camera(&scene, ViewSpec { size: [240, 180], zoom, ..ViewSpec::default() });
        let bits = |threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let frame = pool.install(|| render(&scene, &camera, &options));
            let bits = pixels(camera.size).map(|[x, y]| {
                let parameters = frame.pixel(x, y).map(|p| p.stored.map(f64::to_bits));
                (frame.word(x, y), frame.color(x, y).map(f32::to_bits), parameters)
            });
            bits.collect::<Vec<_>>()
        };
        let one = bits(1);
        assert!(one.iter().any(|(word, ..)| *word != 0), "{name} is not in sight");
        for threads in [2, 5] {
            assert!(bits(threads) == one, "{name} differs on {threads} threads");
        }
    }
}

/// Buffers that a renderer keeps leave no trace of the frame before.
#[test]
fn recycled_buffers_do_not_show() {
    let scene = scene("teapot");
    let options = Options::default();
    let mut renderer = Renderer::new(&scene);
    let spec = |zoom: f64, size: [u32; 2]| ViewSpec { zoom, size, ..ViewSpec::default() };
    for spec in [spec(4.0, [120, 90]), spec(1.0, [120, 90]), spec(0.2, [120, 90]), spec(1.0, [64, 100])] {
        let camera = camera(&scene, spec);
        let (kept, fresh) = (renderer.render(&camera, &options).expect("a frame"), render(&scene, &camera, &options));
        for [x, y] in pixels(spec.size) {
            assert_eq!(kept.word(x, y), fresh.word(x, y), "({x}, {y}), zoom {}", spec.zoom);
        }
        renderer.recycle(kept);
    }
}
