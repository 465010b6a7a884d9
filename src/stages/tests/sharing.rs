//! What is copied between a frame's device and the hardware's rasteriser: nothing, where they share memory.

use crate::cuda::recorded::{Event, Recorded};
use crate::scene::{ViewSpec, prepare};
use crate::stages::{Engine, Options, Raster, Renderer};
use crate::vulkan::{Device, Rasterizer, Validation, VulkanError};
use crate::{emulated, import};
use std::sync::Arc;

fn rasterizer(device: Result<Arc<Device>, VulkanError>) -> Option<Rasterizer> {
    if let Some(why) = crate::emulated::missing() {
        assert!(std::env::var_os("HALFPIXEL_NEEDS_CUDA").is_none(), "{why}");
        return None;
    }
    match device.and_then(Rasterizer::new) {
        Ok(rasterizer) => Some(rasterizer),
        Err(error) => {
            assert!(std::env::var_os("HALFPIXEL_NEEDS_VULKAN").is_none(), "{error}");
            eprintln!("skipped: {error} (scripts/install_lavapipe.sh brings a device)");
            None
        }
    }
}

/// Bytes that go to or from the device while mesh shaders draw, of a frame with as many bytes of vertices and words.
fn transferred(device: Result<Arc<Device>, VulkanError>) -> Option<[usize; 2]> {
    let rasterizer = rasterizer(device)?;
    let scene = prepare(&import::load("builtin:teapot").expect("a model"), &|_, _| {}).expect("a scene");
    let camera = ViewSpec { size: [64, 48], ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
    let mut renderer = Renderer::new(&scene);
    renderer.set_rasterizer(rasterizer);
    let mut gpu = Recorded::default();
    let options = Options { raster: Raster::Hardware, ..Options::default() };
    let frame = renderer.render_on(&mut gpu, &camera, &options).expect("a frame");
    assert!(frame.stats.triangles_hardware > 0);
    let (mut depth, mut bytes) = (0, 0);
    for event in &gpu.events {
        match event {
            Event::Open(name) if depth > 0 || *name == "hardware" => depth += 1,
            Event::Close if depth > 0 => depth -= 1,
            Event::Transfer(more) if depth > 0 => bytes += more,
            _ => {}
        }
    }
    // At least four vertices of 16 bytes a quad of each meshlet's first, and two words a pixel.
    let least = frame.stats.meshlets as usize * 4 * 16 + 2 * 8 * 64 * 48;
    Some([bytes, least])
}

#[test]
fn no_meshlet_and_no_word_is_copied_where_memory_is_shared() {
    if let Some([bytes, least]) = transferred(Device::new(Validation::Off, None)) {
        // Numbers of meshlets, triangles and workgroups.
        assert!(bytes <= 256 && bytes < least, "{bytes} bytes");
    }
    if let Some([bytes, least]) = transferred(Device::unshared(Validation::Off, None)) {
        assert!(bytes >= least, "{bytes} of {least} bytes");
    }
}

/// One renderer draws frames by turns, of several sizes: the words of a fresh one, and nothing is kept that nobody uses.
#[test]
fn hardware_and_software_take_turns() {
    let Some(rasterizer) = rasterizer(Device::new(Validation::Off, None)) else { return };
    let scene = prepare(&import::load("builtin:trimmed:drilled").expect("a model"), &|_, _| {}).expect("a scene");
    let mut renderer = Renderer::new(&scene);
    renderer.set_rasterizer(rasterizer);
    let (mut gpu, mut kept) = (emulated::Device::default(), Vec::new());
    for _ in 0..2 {
        for size in [[64, 48], [1, 1], [90, 70]] {
            let camera = ViewSpec { size, ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
            let expected = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame");
            for raster in [Raster::Software, Raster::Software, Raster::Software, Raster::Hardware, Raster::Hybrid] {
                let options = Options { raster, large: Some(5.0), ..Options::default() };
                let frame = renderer.render_on(&mut gpu, &camera, &options).expect("a frame");
                let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
                let same = |&(x, y): &(u32, u32)| frame.word(x, y) == expected.word(x, y);
                assert!(pixels.clone().all(|at| same(&at)), "{size:?}, {raster:?}");
            }
        }
        kept.push(gpu.allocations());
    }
    assert_eq!(kept[0], kept[1]);
}

/// One line says so, and the next frame opens the device anew.
#[test]
fn a_lost_device_is_opened_again() {
    if rasterizer(Device::new(Validation::Off, None)).is_none() {
        return;
    }
    let scene = prepare(&import::load("builtin:teapot").expect("a model"), &|_, _| {}).expect("a scene");
    let camera = ViewSpec { size: [64, 48], ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
    let options = Options { raster: Raster::Hardware, ..Options::default() };
    for engine in [Engine::Cpu, Engine::Emulated(Box::default())] {
        let mut renderer = Renderer::with(&scene, engine);
        renderer.render(&camera, &options).expect("a frame");
        renderer.hardware.as_mut().expect("it has drawn").lose();
        let error = renderer.render(&camera, &options).expect_err("the device is lost").to_string();
        assert_eq!(error, "--raster: drawing meshlets: the Vulkan device was lost");
        renderer.render(&camera, &options).expect("a frame");
    }
}
