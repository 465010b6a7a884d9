//! What is copied between a frame's device and the hardware's rasteriser: nothing, where they share memory.

use crate::cuda::recorded::{Event, Recorded};
use crate::import;
use crate::scene::{ViewSpec, prepare};
use crate::stages::{Options, Raster, Renderer};
use crate::vulkan::{Device, Rasterizer, Validation, VulkanError};
use std::sync::Arc;

/// Bytes that go to or from the device while mesh shaders draw, of a frame with as many bytes of vertices and words.
fn transferred(device: Result<Arc<Device>, VulkanError>) -> Option<[usize; 2]> {
    if crate::emulated::missing().is_some() {
        return None;
    }
    let rasterizer = match device.and_then(Rasterizer::new) {
        Ok(rasterizer) => rasterizer,
        Err(error) => {
            assert!(std::env::var_os("HALFPIXEL_NEEDS_VULKAN").is_none(), "{error}");
            eprintln!("skipped: {error} (scripts/install_lavapipe.sh brings a device)");
            return None;
        }
    };
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
