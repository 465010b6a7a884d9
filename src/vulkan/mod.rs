//! The hardware's rasteriser: Vulkan mesh shaders that draw the frame's meshlets into the same visibility words (DESIGN
//! sections 1 and 4; ETER section 6.2).
//!
//! What fixed-function hardware makes of triangles is only a proposal here: a fragment shader computes the exact edge functions
//! and the depth of each fragment in the arithmetic of `stages/rasterize.rs`, so that words are the same bit for bit, whatever
//! device draws them. Parameters are nobody's business before `shade`: no weight has to be in W, and all bounds go alike.
//!
//! | file | what it has |
//! |---|---|
//! | `instance.rs` | the loader, and what validation layers say |
//! | `device.rs` | what a device must have, and what is missing where it can't be used |
//! | `memory.rs` | buffers with addresses |
//! | `handle.rs` | what memory and semaphores are passed to other APIs by |
//! | `sharing.rs` | what a device can share with other APIs |
//! | `shared.rs` | buffers and semaphores that other APIs use too |
//! | `pipeline.rs` | mesh pipelines of `vk_shaders/` |
//! | `jobs.rs` | which workgroups a frame takes |
//! | `trims.rs` | trim trees, and fragments that only the exact surface can decide |
//! | `threshold.rs` | what each device has been measured to be good for |
//! | `rasterize.rs` | a frame's meshlets into its two buffers of words |
//! | `rasterize_shared.rs` | the same in memory that the frame's own device sees |
//! | `recorder.rs` | one list of commands, run to its end, and timed |
//! | `tessellation.rs` | what frames do not use: evaluation by fixed-function tessellation (ETER, table 3; Yeo 2012) |
//! | `tessellation_pieces.rs` | patches cut to what hardware tessellates at once |
//! | `tessellation_borders.rs` | which borders of patches coincide |
//! | `tessellation_pipelines.rs` | its pipelines, by degree |
//! | `evaluated.rs` | its counterpart: mesh shaders that read what was evaluated before |

// Foreign code is called in all of these files.
#![allow(unsafe_code)]

mod device;
mod evaluated;
mod handle;
mod instance;
mod jobs;
mod memory;
mod pipeline;
mod rasterize;
mod rasterize_shared;
mod recorder;
mod shared;
mod sharing;
mod tessellation;
mod tessellation_borders;
mod tessellation_pieces;
mod tessellation_pipelines;
pub mod threshold;
mod trims;

pub(crate) use device::uuid_text;
pub use device::{Device, Found, devices};
pub use evaluated::Evaluated;
pub use handle::Handle;
pub use instance::{Instance, Validation};
pub(crate) use jobs::{BINS, Jobs, Wanted};
pub use rasterize::{Drawn, Input, Rasterizer};
pub(crate) use rasterize_shared::SharedInput;
pub use shared::{Order, SharedBuffer, SharedSemaphore, Transfers};
pub use sharing::Semaphores;
pub use tessellation::{Parameters, Sample, Tessellated, Tessellation, Tessellator, with_factor};
pub use tessellation_borders::Borders;
pub use tessellation_pieces::{EdgeFactors, Piece};

use ash::vk;
use thiserror::Error;

/// Why Vulkan can't be used, or no longer.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum VulkanError {
    #[error("no Vulkan loader (libvulkan.so.1): install libvulkan1 and a driver ({reason})")]
    NoLoader { reason: String },
    #[error("no Vulkan driver is installed that works here (VK_DRIVER_FILES may name a wrong one): {code}")]
    NoDriver { code: vk::Result },
    #[error("no Vulkan device is there")]
    NoDevice,
    #[error("{device} can't be used for this, it lacks {}", missing.join(", "))]
    Unfit { device: String, missing: Vec<String> },
    #[error("{device} has no clock that commands can ask (timestampValidBits is 0)")]
    NoTimestamps { device: String },
    #[error("patch {patch} can't be tessellated: {reason}")]
    BadPatch { patch: usize, reason: &'static str },
    #[error("meshlet {meshlet} can't be drawn: {reason}")]
    BadMeshlet { meshlet: usize, reason: &'static str },
    #[error("the Vulkan validation layers are not installed (vulkan-validationlayers)")]
    NoValidation,
    #[error("{what}: the Vulkan device has no memory left for {bytes} bytes")]
    OutOfMemory { what: &'static str, bytes: u64 },
    #[error("{what}: the Vulkan device was lost")]
    Lost { what: &'static str },
    #[error("{what}: {code}")]
    Call { what: &'static str, code: vk::Result },
    #[error("{device} can't share {what} with other APIs")]
    Unshared { what: &'static str, device: String },
    #[error("Vulkan has not signalled {value} to those who wait for it")]
    NotSignalled { value: u64 },
    #[error("a handle that was to be {what} names something else")]
    WrongHandle { what: &'static str },
    #[error("images of {width} x {height} pixels are more than the {limit} a side that {device} can draw")]
    ImageTooLarge { width: u32, height: u32, limit: u32, device: String },
}

impl VulkanError {
    /// The device can't be used any more.
    pub(crate) fn is_final(&self) -> bool {
        matches!(self, Self::Lost { .. } | Self::Call { .. })
    }

    /// Of a failed call.
    fn of(what: &'static str) -> impl Fn(vk::Result) -> Self {
        move |code| match code {
            vk::Result::ERROR_DEVICE_LOST => Self::Lost { what },
            _ => Self::Call { what, code },
        }
    }
}

/// Why no frame can be rasterised by hardware here; empty where one can.
pub fn missing() -> Vec<VulkanError> {
    match devices() {
        Err(error) => vec![error],
        Ok(found) if found.is_empty() => vec![VulkanError::NoDevice],
        Ok(found) if found.iter().any(|d| d.missing.is_empty()) => Vec::new(),
        Ok(found) => found.into_iter().map(|d| VulkanError::Unfit { device: d.name, missing: d.missing }).collect(),
    }
}
