//! Whole frames: `--raster hardware` and `hybrid` store the words that `software` stores.

use crate::{assert_silent, rasterizer};
use halfpixel::import;
use halfpixel::scene::{Scene, ViewSpec, prepare};
use halfpixel::stages::{Bound, Engine, Fill, Frame, Options, Raster, Renderer, Route, Trim};
use halfpixel::verify::{Sampling, verify};
use halfpixel::vulkan::{Device, Rasterizer, Validation};
use std::path::PathBuf;

fn scene(name: &str) -> Scene {
    prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene")
}

/// How many pixels two frames have different words or colours at.
fn differences(a: &Frame, b: &Frame) -> usize {
    let [width, height] = a.size();
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| a.word(x, y) != b.word(x, y) || a.color(x, y) != b.color(x, y)).count()
}

/// Draws views of a scene with options both ways, by one rasteriser.
fn agree(names: &[&str], views: &[ViewSpec], all: &[Options]) {
    let Some(rasterizer) = rasterizer() else { return };
    let mut kept = Some(rasterizer);
    for name in names {
        let scene = scene(name);
        let mut renderer = Renderer::new(&scene);
        renderer.set_rasterizer(kept.take().expect("it is handed on"));
        for (view, options) in views.iter().flat_map(|v| all.iter().map(move |o| (v, o))) {
            let camera = view.camera(&scene.bounds).expect("a camera");
            let software = renderer.render(&camera, options).expect("a frame");
            for raster in [Raster::Hardware, Raster::Hybrid] {
                let frame = renderer.render(&camera, &Options { raster, ..*options }).expect("a frame");
                assert_eq!(differences(&software, &frame), 0, "{name}, {view:?}, {raster:?}, {options:?}");
                if raster == Raster::Hardware && options.trim != Trim::Texture {
                    assert_eq!(frame.stats.triangles_hardware, frame.stats.triangles, "{name}, {view:?}");
                }
            }
        }
        kept = renderer.take_rasterizer();
    }
    assert_silent(&kept.expect("it is handed on"));
}

/// Frames of the kernels, with what mesh shaders draw of them in the same memory, or of copies.
#[test]
fn kernels_and_mesh_shaders_share_frames() {
    let Some(rasterizer) = rasterizer() else { return };
    let shares = rasterizer.device().shares_memory();
    assert!(shares || std::env::var_os("HALFPIXEL_NEEDS_VULKAN").is_none(), "lavapipe shares memory");
    drawn_together(rasterizer, !shares);
    let unshared = Device::unshared(Validation::On, None).and_then(Rasterizer::new).expect("it was there before");
    drawn_together(unshared, true);
}

fn drawn_together(mut rasterizer: Rasterizer, copied: bool) {
    if let Some(why) = halfpixel::emulated::missing() {
        return crate::without::skip(why);
    }
    let trims = [Trim::On, Trim::Texture].map(|trim| Options { trim, ..Options::default() });
    let others = [
        Options { fill: Fill::Eter, ..Options::default() },
        Options { fill: Fill::Conservative, refine: 0, tolerance: 0.3, ..Options::default() },
    ];
    let all = [trims, others].concat();
    for (name, zoom) in [("builtin:teapot", 1.0), ("builtin:drum", 1e5), ("builtin:trimmed:drilled", 1.0)] {
        let scene = scene(name);
        let view = ViewSpec { size: [120, 90], zoom, ..ViewSpec::default() };
        let camera = view.camera(&scene.bounds).expect("a camera");
        let mut reference = Renderer::new(&scene);
        let mut renderer = Renderer::with(&scene, Engine::Emulated(Box::default()));
        renderer.set_rasterizer(rasterizer);
        for options in &all {
            let software = reference.render(&camera, options).expect("a frame");
            let routes = [(Raster::Hardware, None), (Raster::Hybrid, Some(6.0)), (Raster::Hybrid, Some(9.0))];
            for (raster, large) in routes {
                let route = if large == Some(9.0) { Route::Eter } else { Route::Net };
                let options = Options { raster, large, route, ..*options };
                let frame = renderer.render(&camera, &options).expect("a frame");
                assert_eq!(differences(&software, &frame), 0, "{name}, {options:?}");
                let drawn = frame.stats.triangles_hardware > 0;
                assert_eq!(frame.stats.bytes_copied > 0, copied && drawn, "{name}, {options:?}");
                // The routes are the CPU's.
                let triangles = {
                    let rasterizer = renderer.take_rasterizer().expect("it draws");
                    reference.set_rasterizer(rasterizer);
                    let stats = reference.render(&camera, &options).expect("a frame").stats;
                    renderer.set_rasterizer(reference.take_rasterizer().expect("it draws"));
                    stats.triangles_hardware
                };
                assert_eq!(frame.stats.triangles_hardware, triangles, "{name}, {options:?}");
            }
        }
        rasterizer = renderer.take_rasterizer().expect("it draws");
    }
    assert_silent(&rasterizer);
}

fn zoomed(zooms: &[f64]) -> Vec<ViewSpec> {
    let view = |&zoom| ViewSpec { size: [200, 150], zoom, ..ViewSpec::default() };
    zooms.iter().map(view).collect()
}

#[test]
fn words_are_those_of_software() {
    let fills = [Fill::Stroke, Fill::Eter, Fill::Conservative, Fill::Off];
    let options = fills.map(|fill| Options { fill, ..Options::default() });
    agree(&["builtin:teapot", "builtin:drum", "builtin:stress"], &zoomed(&[1.0, 40.0]), &options);
}

#[test]
fn all_bounds_go_alike() {
    let options: Vec<Options> = [Bound::Eter, Bound::Filip, Bound::Projective]
        .into_iter()
        .map(|bound| Options { bound, refine: 0, tolerance: 0.3, ..Options::default() })
        .collect();
    let orthographic = ViewSpec { orthographic: true, ..zoomed(&[3.0])[0] };
    agree(&["builtin:torus", "builtin:teapot"], &[zoomed(&[1.0])[0], orthographic], &options);
}

/// Patches that reach far beyond the viewport.
#[test]
fn what_is_close_is_the_same() {
    let zooms = zoomed(&[2e3, 1e5, 1e7]);
    agree(&["builtin:teapot", "builtin:drum", "builtin:sphere"], &zooms, &[Options::default()]);
}

#[test]
fn trimmed_faces_are_the_same() {
    let options = [Trim::On, Trim::Texture, Trim::Off].map(|trim| Options { trim, ..Options::default() });
    let names =
        ["builtin:trimmed:plate", "builtin:trimmed:drilled", "builtin:trimmed:ball", "builtin:trimmed:degree22"];
    agree(&names, &zoomed(&[1.0, 30.0]), &options);
    let fills = [Fill::Eter, Fill::Conservative].map(|fill| Options { fill, tolerance: 0.3, ..Options::default() });
    let unrefined = Options { refine: 0, tolerance: 0.3, ..Options::default() };
    agree(&names[1..], &zoomed(&[1.0]), &[fills[0], fills[1], unrefined]);
}

/// More fragments near curves than a first frame has room for (16): it is drawn again.
#[test]
fn lists_grow() {
    let view = ViewSpec { size: [900, 700], ..ViewSpec::default() };
    agree(&["builtin:trimmed:drilled"], &[view], &[Options::default()]);
    let scene = scene("builtin:trimmed:drilled");
    let camera = view.camera(&scene.bounds).expect("a camera");
    let stats = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame").stats;
    assert!(stats.trim.tested > 16, "{stats:?}");
}

/// All models there are: the software's words, which keep the contract.
#[test]
fn real_models_are_the_same() {
    let folder = std::env::var_os("HALFPIXEL_MODELS").map_or_else(|| PathBuf::from("../shared/models"), PathBuf::from);
    let Ok(entries) = std::fs::read_dir(&folder) else { return eprintln!("skipped: there is no {}", folder.display()) };
    let known = |path: &PathBuf| {
        let end = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        end.is_some_and(|end| ["step", "stp", "bpt", "bv"].contains(&end.as_str()))
    };
    let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(known).collect();
    found.sort();
    let found: Vec<String> = found.iter().map(|path| path.to_string_lossy().into_owned()).collect();
    let readable: Vec<&str> = found.iter().map(String::as_str).filter(|path| import::load(path).is_ok()).collect();
    assert!(found.is_empty() || !readable.is_empty(), "{found:?}");
    agree(&readable, &zoomed(&[1.0, 8.0]), &[Options::default()]);
    let Some(mut rasterizer) = rasterizer() else { return };
    for path in readable {
        let scene = scene(path);
        let camera = zoomed(&[1.0])[0].camera(&scene.bounds).expect("a camera");
        let mut renderer = Renderer::new(&scene);
        renderer.set_rasterizer(rasterizer);
        for (raster, large) in [(Raster::Hardware, None), (Raster::Hybrid, Some(6.0))] {
            let options = Options { raster, large, ..Options::default() };
            let frame = renderer.render(&camera, &options).expect("a frame");
            let sampling = Sampling { samples: Some(150), seed: 5 };
            let report = verify(&scene, &camera, &options, &|x, y| frame.pixel(x, y), &sampling, &|_, _| ());
            assert!(report.passed(), "{path}, {raster:?}: {report:?}");
        }
        rasterizer = renderer.take_rasterizer().expect("it draws");
    }
}
