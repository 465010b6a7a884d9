//! rasterize by hardware, for frames of a device: which meshlets mesh shaders draw, and how the two devices hand them over. Twin
//! of src/stages/hardware.rs.

use super::count::Count;
use super::frame::Stages;
use super::session::Geometry;
use super::shared::Role;
use super::{Argument, Buffer, Gpu, GpuError, Pointer, TrimLists, abi};
use crate::stages::Fill;
use crate::vulkan::{self, BINS, Jobs, Rasterizer, SharedInput, Wanted};
use std::sync::Arc;

/// What draws meshlets beside a device's kernels.
pub(crate) struct Hardware<'r> {
    pub rasterizer: &'r mut Rasterizer,
    /// Pixels along the longer side of a quad from which on a leaf is drawn by it.
    pub large: f32,
    /// By ETER's rule.
    pub by_edges: bool,
    pub fill: Fill,
    /// Of the scene, where trees decide.
    pub trims: Option<Arc<TrimLists>>,
    /// Fragments stay as they are: strokes' own parameters are tested.
    pub alone: bool,
}

/// What hardware did in a frame, besides words.
#[derive(Debug, Default)]
pub(crate) struct ByHardware {
    /// How many it was given.
    pub triangles: u64,
    /// Bytes of meshlets, vertices and words that were copied from one device to the other.
    pub copied: u64,
    /// Near trim curves: left to `trim`.
    pub listed: Vec<abi::Fragment>,
}

impl<G: Gpu> Stages<'_, '_, G> {
    /// Draws what is routed to the hardware into both buffers, before anything else is in them.
    pub(super) fn rasterize_by_hardware(&mut self, hardware: &mut Hardware) -> Result<(), GpuError> {
        let [meshlets, triangles] = self.mark(hardware)?;
        self.hardware.triangles = triangles;
        let drawn = meshlets == 0 || self.shared(hardware)?;
        if drawn { Ok(()) } else { self.copied(hardware) }
    }

    /// Marks the meshlets of leaves with large quads: how many these are, and their triangles.
    fn mark(&mut self, hardware: &Hardware) -> Result<[u64; 2], GpuError> {
        let (geometry, count) = (self.geometry, self.geometry.meshlets.count);
        let taken = self.session.allocate::<u8>(self.leaves.room())?.pointer();
        let counted = self.session.zeroed::<[u64; 2]>(1)?;
        let (patches, nets) = (geometry.patches.pointer(), geometry.nets.pointer());
        let view = geometry.view;
        let leaves = self.leaves;
        let (large, by_edges) = (hardware.large, u32::from(hardware.by_edges));
        self.session.for_all(
            "hardware_leaves",
            leaves,
            &[&view, &leaves, &patches, &nets, &large, &by_edges, &taken],
        )?;
        let (textured, meshlets) = (u32::from(self.textured), geometry.meshlets.pointer());
        self.session.for_all("hardware_marks", count, &[&count, &taken, &textured, &meshlets, &counted.pointer()])?;
        Ok(self.session.download(&counted)?.first().copied().unwrap_or_default())
    }

    /// In memory that both devices see; false where there is none.
    fn shared(&mut self, hardware: &mut Hardware) -> Result<bool, GpuError> {
        if self.session.shared.is_none() {
            return Ok(false);
        }
        let (size, count) = (self.geometry.view.size, self.geometry.meshlets.count);
        let wanted = hardware.rasterizer.wanted(hardware.fill, size);
        let counted = self.session.zeroed::<[u64; BINS]>(1)?;
        self.jobs(&wanted, &counted, &[0; BINS], Pointer::NULL)?;
        let counts = self.session.download(&counted)?;
        let needed = counts.iter().flatten().sum();
        let too_many = || GpuError::TooMany { what: "workgroups", needed, limit: u32::MAX.into() };
        let jobs = counts.first().and_then(|counts| Jobs::new(counts, hardware.fill)).ok_or_else(too_many)?;
        let list = self.session.allocate_as::<u32>(Role::Jobs, jobs.all as usize)?;
        let counted = self.session.zeroed::<[u64; BINS]>(1)?;
        self.jobs(&wanted, &counted, &jobs.first, list.pointer())?;
        let drawn = self.session.hand_over(|shared| {
            let memory = |role| shared.memory(role).ok_or(GpuError::Unsettled);
            let drawn = hardware.rasterizer.draw_shared(&SharedInput {
                size,
                fill: hardware.fill,
                patches: memory(Role::Patches)?,
                leaves: memory(Role::Leaves)?,
                meshlets: memory(Role::Meshlets)?,
                all: count.room() as u32,
                vertices: memory(Role::Vertices)?,
                listed: memory(Role::Jobs)?,
                jobs: &jobs,
                near: memory(Role::Near)?,
                spare: memory(Role::Spare)?,
                trims: hardware.trims.as_ref(),
                alone: hardware.alone,
                order: shared.order(),
            })?;
            Ok(drawn.to_vec())
        })?;
        self.hardware.listed = drawn.unwrap_or_default();
        Ok(true)
    }

    /// Counts the workgroups by bins and, where `out` is not null, lists them.
    fn jobs(
        &mut self,
        wanted: &Wanted,
        counted: &Buffer<[u64; BINS]>,
        first: &[u32; BINS],
        out: Pointer<u32>,
    ) -> Result<(), GpuError> {
        let Geometry { patches, leaves, meshlets, vertices, .. } = self.geometry;
        let vertices = vertices.map_or(Pointer::NULL, |vertices| vertices.pointer());
        let lists = (patches.pointer(), leaves.pointer(), meshlets.pointer());
        let (count, counted) = (meshlets.count, counted.pointer());
        let all: [&dyn Argument; 9] = [&count, &lists.0, &lists.1, &lists.2, &vertices, wanted, &counted, first, &out];
        self.session.for_all("hardware_jobs", count, &all)
    }

    /// By way of the host: where the two devices share no memory.
    fn copied(&mut self, hardware: &mut Hardware) -> Result<(), GpuError> {
        let Some(vertices) = self.geometry.vertices else { return Ok(()) };
        let patches = self.session.download(&self.geometry.patches)?;
        let leaves = self.session.download(&self.geometry.leaves)?;
        let mut meshlets = self.session.download(&self.geometry.meshlets.buffer)?;
        let vertices = self.session.download(&vertices)?;
        let marked = |m: &abi::Meshlet| u32::from(m.tested) & abi::MESHLET_ELSEWHERE != 0;
        let numbers: Vec<u32> = (0u32..).zip(&meshlets).filter(|(_, m)| marked(m)).map(|(k, _)| k).collect();
        meshlets.iter_mut().for_each(|m| m.tested &= abi::MESHLET_TESTED as u8);
        let drawn = hardware.rasterizer.draw(&vulkan::Input {
            size: self.geometry.view.size,
            fill: hardware.fill,
            patches: &patches,
            leaves: &leaves,
            meshlets: &meshlets,
            vertices: &vertices,
            numbers: &numbers,
            trims: hardware.trims.as_ref(),
            alone: hardware.alone,
        })?;
        self.near = self.session.upload(drawn.near)?;
        self.spare = self.session.upload(drawn.spare)?;
        (self.hardware.listed, self.hardware.copied) = (drawn.listed.to_vec(), drawn.copied);
        Ok(())
    }

    /// The fragments that only the exact surface can decide.
    pub(super) fn trim_listed(&mut self, counted: Pointer<u64>) -> Result<(), GpuError> {
        if self.hardware.listed.is_empty() {
            return Ok(());
        }
        let list = self.session.upload(&self.hardware.listed)?;
        let (near, spare, trims) = (self.near.pointer(), self.spare.pointer(), self.trims);
        let count = Count::known(list.len() as u32);
        let rest: [&dyn Argument; 6] = [&trims, &near, &spare, &list.pointer(), &count, &counted];
        self.session.for_each_in(&self.geometry, "trim_fragments", list.len(), &rest)
    }
}
