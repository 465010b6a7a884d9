//! Counts and times of one frame; one type for every backend.

use super::TrimCounts;
use serde::Serialize;
use std::time::Instant;

/// The frame's stages, in their order (DESIGN section 1).
pub const STAGES: [&str; 7] = ["cull", "estimate", "evaluate", "rasterize", "trim", "fill", "shade"];

/// Wall-clock time of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageTime {
    pub stage: &'static str,
    pub ms: f64,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Stats {
    pub stages: Vec<StageTime>,
    pub patches: u64,
    pub patches_visible: u64,
    /// Pieces that were drawn: visible patches, or parts of them where they were split.
    pub leaves: u64,
    pub meshlets: u64,
    pub quads: u64,
    /// Generated after culling.
    pub triangles: u64,
    /// Those of them that Vulkan's mesh shaders were given.
    pub triangles_hardware: u64,
    /// Bytes of meshlets, vertices and visibility words that were copied between what draws the frame and Vulkan's device.
    pub bytes_copied: u64,
    /// Pixels that the spare buffer decided.
    pub filled: u64,
    pub drawn: u64,
    pub trim: TrimCounts,
    pub buffer_bytes: u64,
    /// On a device: lists got their room by asking how long they are, as in a first frame, or in one that needs much more of
    /// something than the last. Others ask for nothing before their end.
    pub asked: bool,
}

/// Times stages that follow each other.
pub(super) struct Clock {
    last: Instant,
    stages: Vec<StageTime>,
}

impl Clock {
    pub fn new() -> Self {
        Self { last: Instant::now(), stages: Vec::new() }
    }

    /// Books the time since the last call under a stage's name.
    pub fn stage(&mut self, stage: &'static str) {
        let now = Instant::now();
        self.stages.push(StageTime { stage, ms: (now - self.last).as_secs_f64() * 1e3 });
        self.last = now;
    }

    pub fn stages(self) -> Vec<StageTime> {
        self.stages
    }

    /// The same by a device's clock, where that has timed all of them.
    pub fn stages_by(mut self, device: &[f64]) -> Vec<StageTime> {
        if device.len() == self.stages.len() {
            self.stages.iter_mut().zip(device).for_each(|(stage, &ms)| stage.ms = ms);
        }
        self.stages
    }
}
