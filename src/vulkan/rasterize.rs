//! rasterize: a frame's meshlets by mesh shaders, into its two buffers of visibility words.

use super::jobs::{self, Draw};
use super::memory::{Buffer, Use};
use super::pipeline::{Kind, PUSH_BYTES, Pipelines, Push};
use super::threshold;
use super::trims::Trims;
use super::{Device, VulkanError};
use crate::cuda::{Pod, TrimLists, abi};
use crate::stages::Fill;
use ash::vk;
use std::sync::Arc;

/// Workgroups along one axis of a draw, and in all of it: what every device can do.
pub(super) const MOST_GROUPS: u32 = 65535;
pub(super) const MOST_IN_ALL: u32 = (1 << 22) / MOST_GROUPS * MOST_GROUPS;
/// Two minutes: a driver's own watchdog comes sooner.
pub(super) const TIMEOUT: u64 = 120_000_000_000;

/// What is drawn. Lists are those of `kernels/abi.h`.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    pub size: [u32; 2],
    pub fill: Fill,
    pub patches: &'a [abi::Patch],
    pub leaves: &'a [abi::Leaf],
    pub meshlets: &'a [abi::Meshlet],
    pub vertices: &'a [abi::Vertex],
    /// The meshlets that are drawn; none of them twice.
    pub numbers: &'a [u32],
    /// Of the scene, where `tested` meshlets are among them.
    pub trims: Option<&'a Arc<TrimLists>>,
    /// Fragments stay as they are: strokes' own parameters are tested.
    pub alone: bool,
}

/// What became of a frame: by pixel, row by row, words of centre-covered fragments and of those that may close a crack, 0 where
/// there are none; and, in no order, fragments near trim curves, which only the exact surface can decide.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    pub near: &'a [u64],
    pub spare: &'a [u64],
    pub listed: &'a [abi::Fragment],
}

/// Draws meshlets; keeps its buffers from frame to frame.
pub struct Rasterizer {
    // Before `device`: fields are dropped in order, and buffers and pipelines hold the device themselves.
    buffers: Buffers,
    pipelines: Pipelines,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    done: vk::Fence,
    device: Arc<Device>,
    /// Pixels along the longer side of a quad from which on it is worth drawing here.
    large: f64,
}

#[derive(Default)]
struct Buffers {
    patches: Option<Buffer>,
    leaves: Option<Buffer>,
    meshlets: Option<Buffer>,
    vertices: Option<Buffer>,
    numbers: Option<Buffer>,
    near: Option<Buffer>,
    spare: Option<Buffer>,
    words: [Option<Buffer>; 2],
    trims: Option<Trims>,
}

/// What one frame is drawn with.
struct Frame<'a> {
    input: Input<'a>,
    push: Push,
    draws: Vec<Draw>,
    /// From where to where words are copied for the host, and what trimming lists.
    copies: Vec<Copied>,
}

struct Copied {
    from: vk::Buffer,
    to: vk::Buffer,
    bytes: u64,
}

impl Rasterizer {
    pub fn new(device: Arc<Device>) -> Result<Self, VulkanError> {
        let pipelines = Pipelines::new(&device)?;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(device.family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: the family is the queue's.
        let pool = unsafe { device.raw.create_command_pool(&info, None) };
        let pool = pool.map_err(VulkanError::of("vkCreateCommandPool"))?;
        let mut made = Self {
            buffers: Buffers::default(),
            pipelines,
            pool,
            commands: vk::CommandBuffer::null(),
            done: vk::Fence::null(),
            large: threshold::stored(&device.found).unwrap_or(threshold::UNMEASURED),
            device,
        };
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        // SAFETY: the pool was made above and lives as long as what is made here.
        unsafe {
            let all = made.device.raw.allocate_command_buffers(&info);
            made.commands = all.map_err(VulkanError::of("vkAllocateCommandBuffers"))?[0];
            let fence = made.device.raw.create_fence(&vk::FenceCreateInfo::default(), None);
            made.done = fence.map_err(VulkanError::of("vkCreateFence"))?;
        }
        Ok(made)
    }

    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Pixels along the longer side of a quad from which on this device draws it faster than software, as far as that has been
    /// measured.
    pub fn large(&self) -> f64 {
        self.large
    }

    /// Draws meshlets into buffers of their own.
    pub fn draw(&mut self, input: &Input) -> Result<Drawn<'_>, VulkanError> {
        let [width, height] = input.size;
        if width.max(height) > self.device.largest {
            let (limit, device) = (self.device.largest, self.device.found.name.clone());
            return Err(VulkanError::ImageTooLarge { width, height, limit, device });
        }
        loop {
            let frame = self.upload(input)?;
            self.record(&frame)?;
            self.run()?;
            let trims = self.buffers.trims.as_mut().filter(|_| input.trims.is_some());
            if trims.map_or(Ok(true), |trims| trims.has_room(&self.device))? {
                break;
            }
        }
        let pixels = width as usize * height as usize;
        let [near, spare] =
            self.buffers.words.each_ref().map(|words| words.as_ref().map_or(&[][..], |w| w.read(pixels)));
        let trims = self.buffers.trims.as_ref().filter(|_| input.trims.is_some());
        Ok(Drawn { near, spare, listed: trims.map_or(&[], Trims::found) })
    }

    fn upload<'a>(&mut self, input: &Input<'a>) -> Result<Frame<'a>, VulkanError> {
        let Self { device, buffers, pipelines, .. } = self;
        let middle = input.size.map(|n| n as i32 / 2);
        let mut push = Push { size: input.size, middle, half_viewport: device.half_viewport as i32, ..Push::default() };
        let (jobs, draws) = jobs::jobs(input, &push);
        push.patches = filled(device, &mut buffers.patches, input.patches)?;
        push.leaves = filled(device, &mut buffers.leaves, input.leaves)?;
        push.meshlets = filled(device, &mut buffers.meshlets, input.meshlets)?;
        push.vertices = filled(device, &mut buffers.vertices, input.vertices)?;
        push.numbers = filled(device, &mut buffers.numbers, &jobs)?;
        push.all = input.meshlets.len() as u32;
        let bytes = u64::from(input.size[0]) * u64::from(input.size[1]) * size_of::<u64>() as u64;
        let near = room(device, &mut buffers.near, bytes, Use::Shaders)?;
        let spare = room(device, &mut buffers.spare, bytes, Use::Shaders)?;
        (push.near, push.spare) = (near.address, spare.address);
        let [near_words, spare_words] = &mut buffers.words;
        let mut copies = vec![
            Copied { from: near.raw, to: room(device, near_words, bytes, Use::Download)?.raw, bytes },
            Copied { from: spare.raw, to: room(device, spare_words, bytes, Use::Download)?.raw, bytes },
        ];
        if let Some(lists) = input.trims {
            pipelines.make(true)?;
            let trims = Trims::of(device, &mut buffers.trims, lists)?;
            push.trims = trims.tell(input.alone);
            let (count, listed) = (size_of::<u64>() as u64, trims.listed.bytes());
            copies.push(Copied { from: trims.count.raw, to: trims.counted.raw, bytes: count });
            copies.push(Copied { from: trims.queue.raw, to: trims.listed.raw, bytes: listed });
        }
        Ok(Frame { input: *input, push, draws, copies })
    }

    fn record(&self, frame: &Frame) -> Result<(), VulkanError> {
        let (raw, commands) = (&self.device.raw, self.commands);
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last frame is done, so the commands may be written anew; the buffers live until the next `upload`, which
        // comes after this frame.
        unsafe {
            raw.begin_command_buffer(commands, &once).map_err(VulkanError::of("vkBeginCommandBuffer"))?;
            // The queue of fragments may keep what it had: its count says how many there are.
            for Copied { from, .. } in frame.copies.iter().take(3) {
                raw.cmd_fill_buffer(commands, *from, 0, vk::WHOLE_SIZE, 0);
            }
        }
        self.barrier(vk::PipelineStageFlags2::CLEAR, vk::PipelineStageFlags2::FRAGMENT_SHADER);
        let [near, spare] = jobs::passes(frame.input.fill);
        self.pass(frame, near);
        self.barrier(vk::PipelineStageFlags2::FRAGMENT_SHADER, vk::PipelineStageFlags2::FRAGMENT_SHADER);
        self.pass(frame, spare);
        self.barrier(vk::PipelineStageFlags2::FRAGMENT_SHADER, vk::PipelineStageFlags2::COPY);
        for &Copied { from, to, bytes } in &frame.copies {
            // SAFETY: as above; both buffers have that room.
            unsafe { raw.cmd_copy_buffer(commands, from, to, &[vk::BufferCopy::default().size(bytes)]) };
        }
        self.barrier(vk::PipelineStageFlags2::COPY, vk::PipelineStageFlags2::HOST);
        // SAFETY: the commands were begun above.
        unsafe { raw.end_command_buffer(commands) }.map_err(VulkanError::of("vkEndCommandBuffer"))
    }

    /// All that is drawn before anybody looks at it.
    fn pass(&self, frame: &Frame, kinds: &[Kind]) {
        let (raw, commands, [width, height]) = (&self.device.raw, self.commands, frame.input.size);
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let rendering = vk::RenderingInfo::default().render_area(area).layer_count(1);
        let Push { middle, half_viewport, .. } = frame.push;
        let half = half_viewport as f32;
        let viewport = vk::Viewport {
            x: middle[0] as f32 - half,
            y: middle[1] as f32 - half,
            width: 2.0 * half,
            height: 2.0 * half,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        // SAFETY: commands are being recorded; the pipelines and all that shaders are told of live until they have run.
        unsafe {
            raw.cmd_begin_rendering(commands, &rendering);
            raw.cmd_set_viewport(commands, 0, &[viewport]);
            raw.cmd_set_scissor(commands, 0, &[area]);
        }
        frame.draws.iter().filter(|draw| kinds.contains(&draw.kind)).for_each(|draw| self.meshlets(draw, &frame.push));
        // SAFETY: as above.
        unsafe { raw.cmd_end_rendering(commands) };
    }

    /// One list of workgroups, in as many draws as it takes.
    fn meshlets(&self, draw: &Draw, push: &Push) {
        let (raw, commands) = (&self.device.raw, self.commands);
        let stages = vk::ShaderStageFlags::MESH_EXT | vk::ShaderStageFlags::FRAGMENT;
        let pipeline = self.pipelines.of(draw.kind, draw.trimmed);
        let end = draw.first + draw.count;
        // SAFETY: as in `pass`.
        unsafe { raw.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pipeline) };
        for first in (draw.first..end).step_by(MOST_IN_ALL as usize) {
            let count = MOST_IN_ALL.min(end - first);
            let push = Push { first, count: first + count, ..*push };
            // SAFETY: as in `pass`. `Push` is numbers without padding, of the size that the layout has.
            unsafe {
                let bytes = std::slice::from_raw_parts((&raw const push).cast::<u8>(), PUSH_BYTES as usize);
                raw.cmd_push_constants(commands, self.pipelines.layout, stages, 0, bytes);
                let rows = count.div_ceil(MOST_GROUPS);
                self.device.mesh.cmd_draw_mesh_tasks(commands, count.min(MOST_GROUPS), rows, 1);
            }
        }
    }

    /// What comes after sees what was written before.
    fn barrier(&self, before: vk::PipelineStageFlags2, after: vk::PipelineStageFlags2) {
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(before)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(after)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: commands are being recorded, outside of rendering.
        unsafe { self.device.raw.cmd_pipeline_barrier2(self.commands, &info) };
    }

    /// Runs what was recorded, to its end.
    fn run(&self) -> Result<(), VulkanError> {
        let (raw, all) = (&self.device.raw, [self.commands]);
        let submits = [vk::SubmitInfo::default().command_buffers(&all)];
        // SAFETY: the commands are recorded, the fence is not signalled, and nobody else uses the queue.
        unsafe {
            raw.queue_submit(self.device.queue, &submits, self.done).map_err(VulkanError::of("vkQueueSubmit"))?;
            raw.wait_for_fences(&[self.done], true, TIMEOUT).map_err(VulkanError::of("drawing meshlets"))?;
            raw.reset_fences(&[self.done]).map_err(VulkanError::of("vkResetFences"))
        }
    }
}

impl Drop for Rasterizer {
    fn drop(&mut self) {
        // SAFETY: nothing runs once the wait returns; all three are this rasteriser's own.
        unsafe {
            let _ = self.device.raw.device_wait_idle();
            self.device.raw.destroy_fence(self.done, None);
            self.device.raw.destroy_command_pool(self.pool, None);
        }
    }
}

impl std::fmt::Debug for Rasterizer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Rasterizer").field(&self.device).finish()
    }
}

/// A buffer with room for so many bytes: the last frame's, or a new one that is half as large again.
pub(super) fn room<'a>(
    device: &Arc<Device>,
    kept: &'a mut Option<Buffer>,
    bytes: u64,
    used: Use,
) -> Result<&'a mut Buffer, VulkanError> {
    if kept.as_ref().is_none_or(|b| b.bytes() < bytes) {
        let more = if kept.is_some() { bytes + bytes / 2 } else { bytes };
        *kept = None;
        *kept = Some(Buffer::new(device, more, used)?);
    }
    Ok(kept.as_mut().expect("it was made above"))
}

/// The same with values; their address.
fn filled<T: Pod>(device: &Arc<Device>, kept: &mut Option<Buffer>, values: &[T]) -> Result<u64, VulkanError> {
    let buffer = room(device, kept, size_of_val(values) as u64, Use::Upload)?;
    buffer.write(values.iter().copied());
    Ok(buffer.address)
}
