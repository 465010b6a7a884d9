//! Vulkan's mesh shaders: the same words as the software rasteriser and as exact integers, under validation layers; and
//! evaluation by tessellation.

mod frames;
mod primitives;
mod program;
mod sharing;
mod tessellation;
#[path = "../support/skip.rs"]
mod without;

use halfpixel::vulkan::{Device, Rasterizer, Validation, VulkanError};

/// A rasteriser whose calls are validated. `None`, with a line that says why, where no device will do: CI asks for one.
fn rasterizer() -> Option<Rasterizer> {
    let made = Device::new(Validation::On, None).and_then(Rasterizer::new);
    match made {
        Ok(rasterizer) => Some(rasterizer),
        Err(error) => {
            skip(&error);
            None
        }
    }
}

fn skip(error: &VulkanError) {
    assert!(std::env::var_os("HALFPIXEL_NEEDS_VULKAN").is_none(), "{error}");
    eprintln!("skipped: {error} (scripts/install_lavapipe.sh brings a device)");
}

/// Validation layers have said nothing.
fn assert_silent(rasterizer: &Rasterizer) {
    let messages = rasterizer.device().messages();
    assert!(messages.is_empty(), "{messages:#?}");
}
