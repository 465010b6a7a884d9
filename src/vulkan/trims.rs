//! Trim trees for shaders, and the list of fragments that only the exact surface can decide.

use super::memory::{Buffer, Use};
use super::{Device, VulkanError};
use crate::cuda::{Pod, TrimLists, abi};
use std::sync::Arc;

/// Fragments that there is room for at first: few, so that every scene with many shows that lists grow.
const ROOM: u32 = 16;

/// What shaders are told: `Trims` of vk_shaders/trim.glsl.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct Told {
    trees: u64,
    nodes: u64,
    clips: u64,
    segments: u64,
    points: u64,
    queue: u64,
    count: u64,
    room: u32,
    alone: u32,
}

// SAFETY: numbers, without padding; any bytes are a value of it.
unsafe impl Pod for Told {}

/// A scene's trees and a frame's list in device memory.
pub(super) struct Trims {
    /// Whose trees these are.
    of: Arc<TrimLists>,
    trees: [Buffer; 5],
    told: Buffer,
    pub queue: Buffer,
    pub count: Buffer,
    /// Where the host reads both.
    pub listed: Buffer,
    pub counted: Buffer,
    room: u32,
}

impl Trims {
    /// Of a scene, kept as long as it is the same.
    pub fn of<'a>(
        device: &Arc<Device>,
        kept: &'a mut Option<Self>,
        lists: &Arc<TrimLists>,
    ) -> Result<&'a mut Self, VulkanError> {
        if !kept.as_ref().is_some_and(|trims| Arc::ptr_eq(&trims.of, lists)) {
            *kept = None;
        }
        match kept {
            Some(trims) => Ok(trims),
            none => Ok(none.insert(Self::new(device, lists.clone())?)),
        }
    }

    fn new(device: &Arc<Device>, of: Arc<TrimLists>) -> Result<Self, VulkanError> {
        let trees = [
            filled(device, &of.trees)?,
            filled(device, &of.nodes)?,
            filled(device, &of.clips)?,
            filled(device, &of.segments)?,
            filled(device, &of.points)?,
        ];
        Ok(Self {
            of,
            trees,
            told: Buffer::new(device, size_of::<Told>() as u64, Use::Upload)?,
            queue: Buffer::new(device, bytes(ROOM), Use::Shaders)?,
            count: Buffer::new(device, size_of::<u64>() as u64, Use::Shaders)?,
            listed: Buffer::new(device, bytes(ROOM), Use::Download)?,
            counted: Buffer::new(device, size_of::<u64>() as u64, Use::Download)?,
            room: ROOM,
        })
    }

    /// Tells shaders; what push constants name. `alone`: fragments stay as they are, and their own parameters are tested.
    pub fn tell(&mut self, alone: bool) -> u64 {
        let [trees, nodes, clips, segments, points] = self.trees.each_ref().map(|b| b.address);
        let (queue, count) = (self.queue.address, self.count.address);
        let told =
            Told { trees, nodes, clips, segments, points, queue, count, room: self.room, alone: u32::from(alone) };
        self.told.write([told].into_iter());
        self.told.address
    }

    /// False, and more room for the next time, where the last frame listed more than there was room for.
    pub fn has_room(&mut self, device: &Arc<Device>) -> Result<bool, VulkanError> {
        let count = self.count();
        if count > u64::from(self.room) {
            let what = "fragments near trim curves";
            let room = u32::try_from(count + count / 4);
            let room = room.map_err(|_| VulkanError::OutOfMemory { what, bytes: count.saturating_mul(16) })?;
            self.queue = Buffer::new(device, bytes(room), Use::Shaders)?;
            self.listed = Buffer::new(device, bytes(room), Use::Download)?;
            self.room = room;
            return Ok(false);
        }
        Ok(true)
    }

    /// What the last frame listed.
    pub fn found(&self) -> &[abi::Fragment] {
        self.listed.read(self.count().min(u64::from(self.room)) as usize)
    }

    fn count(&self) -> u64 {
        self.counted.read(1).first().copied().unwrap_or_default()
    }
}

fn bytes(fragments: u32) -> u64 {
    u64::from(fragments) * size_of::<abi::Fragment>() as u64
}

fn filled<T: Pod>(device: &Arc<Device>, values: &[T]) -> Result<Buffer, VulkanError> {
    let mut buffer = Buffer::new(device, size_of_val(values) as u64, Use::Upload)?;
    buffer.write(values.iter().copied());
    Ok(buffer)
}
