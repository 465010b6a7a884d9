//! The mesh-shader side of ETER's table 3: meshlets whose vertices an evaluation left in memory are read and emitted.

use super::rasterize::{MOST_GROUPS, MOST_IN_ALL};
use super::tessellation::{On, pushed};
use super::tessellation_pipelines::{TessellationPush, Work};
use super::{Tessellator, VulkanError};
use crate::cuda::abi;
use crate::report::Spread;
use ash::vk;

/// Vertices that were evaluated before.
#[derive(Clone, Copy, Debug)]
pub struct Evaluated<'a> {
    pub size: [u32; 2],
    pub patches: &'a [abi::Patch],
    pub meshlets: &'a [abi::Meshlet],
    /// Pixels about the patch's centre and depth, with unit normals. The list is repeated on the device until all that meshlets
    /// name is there: 82 million vertices, as in the paper, need not be made by the host.
    pub points: &'a [abi::SurfacePoint],
}

impl Tessellator {
    /// What the mesh shader emits, in the order of `Meshlet::vertices`.
    pub fn emit(&mut self, input: &Evaluated) -> Result<Vec<abi::SurfacePoint>, VulkanError> {
        self.recorder.check()?;
        let push = self.prepare_meshlets(input)?;
        let pipeline = self.pipelines.of(Work::Meshlets, true)?;
        let samples = self.store(push, vertices(input), |on, push| draw(on, pipeline, push))?;
        Ok(samples.iter().map(|s| abi::SurfacePoint { position: s.position, normal: s.normal }).collect())
    }

    /// Milliseconds to read, emit and discard all vertices, on the device's clock.
    pub fn time_meshlets(&mut self, input: &Evaluated, rounds: u32) -> Result<Spread, VulkanError> {
        self.recorder.check()?;
        let push = self.prepare_meshlets(input)?;
        let pipeline = self.pipelines.of(Work::Meshlets, false)?;
        self.clock(push, rounds, |on, push| draw(on, pipeline, push))
    }

    fn prepare_meshlets(&mut self, input: &Evaluated) -> Result<TessellationPush, VulkanError> {
        check(input)?;
        let device = self.recorder.device.clone();
        let mut copies = Vec::new();
        let push = TessellationPush {
            patches: self.patches.fill(&device, input.patches, input.patches.len(), &mut copies)?,
            list: self.list.fill(&device, input.meshlets, input.meshlets.len(), &mut copies)?,
            values: self.values.fill(&device, input.points, vertices(input), &mut copies)?,
            count: input.meshlets.len() as u32,
            ..pushed(&device, input.size, &abi::View::default())
        };
        self.upload(&copies)?;
        Ok(push)
    }
}

/// One past the last vertex.
fn vertices(input: &Evaluated) -> usize {
    let end = |m: &abi::Meshlet| m.vertices as usize + m.quads.map(|n| usize::from(n) + 1).iter().product::<usize>();
    input.meshlets.iter().map(end).max().unwrap_or(0)
}

/// A workgroup a meshlet, in as many draws as it takes.
fn draw(on: &On, pipeline: vk::Pipeline, push: &TessellationPush) {
    let most = MOST_IN_ALL / MOST_GROUPS * MOST_GROUPS;
    for first in (0..push.count).step_by(most as usize) {
        let count = most.min(push.count - first);
        on.bind(pipeline, &TessellationPush { first, ..*push });
        let rows = count.div_ceil(MOST_GROUPS);
        // SAFETY: commands are being recorded, in rendering; groups beyond the last meshlet emit nothing.
        unsafe { on.recorder.device.mesh.cmd_draw_mesh_tasks(on.recorder.commands, count.min(MOST_GROUPS), rows, 1) };
    }
}

/// The shader reads what meshlets say: all of it must be there.
fn check(input: &Evaluated) -> Result<(), VulkanError> {
    let most = abi::MESHLET_VERTICES as u8 - 1;
    for (k, meshlet) in input.meshlets.iter().enumerate() {
        let reason = if meshlet.patch as usize >= input.patches.len() {
            "its patch is not in the list"
        } else if meshlet.quads.iter().any(|n| !(1..=most).contains(n)) {
            "it has 1 to 7 quads a side"
        } else if input.points.is_empty() {
            "there are no vertices"
        } else {
            continue;
        };
        return Err(VulkanError::BadMeshlet { meshlet: k, reason });
    }
    Ok(())
}
