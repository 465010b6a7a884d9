//! rasterize: a frame's meshlets by mesh shaders, into its two buffers of visibility words.

use super::jobs::{self, Draw, Wanted};
use super::memory::{Buffer, Use};
use super::pipeline::{Kind, PUSH_BYTES, Pipelines, Push};
use super::recorder::{Copy, Recorder};
use super::trims::Trims;
use super::{Device, Order, SharedBuffer, VulkanError};
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
    /// Bytes of lists and words that went to the device and came from it.
    pub copied: u64,
}

/// Draws meshlets; keeps its buffers from frame to frame.
pub struct Rasterizer {
    // Before `recorder`, whose device they hold too; `drop` waits first.
    buffers: Buffers,
    pub(super) pipelines: Pipelines,
    pub(super) recorder: Recorder,
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
pub(super) struct Frame<'a> {
    pub size: [u32; 2],
    pub fill: Fill,
    pub push: Push,
    pub draws: Vec<Draw>,
    /// What is 0 before anything is drawn.
    pub clears: Vec<vk::Buffer>,
    /// From where to where words are copied for the host, and what trimming lists.
    pub copies: Vec<Copy>,
    /// What another device has written, and will read.
    pub shared: Vec<&'a SharedBuffer>,
}

impl Rasterizer {
    pub fn new(device: Arc<Device>) -> Result<Self, VulkanError> {
        let pipelines = Pipelines::new(&device)?;
        let mut made = Self { buffers: Buffers::default(), pipelines, recorder: Recorder::new(device)? };
        made.probe()?;
        Ok(made)
    }

    /// Shaders can only refuse what hardware proposes, and Vulkan leaves to it what happens to centres on an edge: a square whose
    /// sides and diagonal run through pixel centres must have its left and its top ones.
    fn probe(&mut self) -> Result<(), VulkanError> {
        let corners = [[128, 128], [128, 640], [640, 128], [640, 640]];
        let drawn = self.draw(&Input {
            size: [4, 4],
            fill: Fill::Off,
            patches: &[abi::Patch { quads: [1, 1], degree: [1, 1], ..Default::default() }],
            leaves: &[abi::Leaf::default()],
            meshlets: &[abi::Meshlet { quads: [1, 1], ..Default::default() }],
            vertices: &corners.map(|[x, y]| abi::Vertex { x, y, depth: 0.5, weight: 1.0 }),
            numbers: &[0],
            trims: None,
            alone: false,
        })?;
        let covered: Vec<usize> = (0..16).filter(|&k| drawn.near[k] != 0).collect();
        if covered == [0, 1, 4, 5] {
            return Ok(());
        }
        let device = self.recorder.device.found.name.clone();
        Err(VulkanError::Unfit { device, missing: vec!["the top-left rule".into()] })
    }

    pub fn device(&self) -> &Arc<Device> {
        &self.recorder.device
    }

    /// Draws meshlets into buffers of their own.
    pub fn draw(&mut self, input: &Input) -> Result<Drawn<'_>, VulkanError> {
        check(input)?;
        self.check_size(input.size)?;
        loop {
            let frame = self.upload(input)?;
            self.run(&frame, &Order::default())?;
            if self.lists_fit(input.trims)? {
                break;
            }
        }
        let [width, height] = input.size;
        let pixels = width as usize * height as usize;
        let [near, spare] =
            self.buffers.words.each_ref().map(|words| words.as_ref().map_or(&[][..], |w| w.read(pixels)));
        let lists = [size_of_val(input.patches), size_of_val(input.leaves), size_of_val(input.meshlets)];
        let lists = lists.iter().sum::<usize>() + size_of_val(input.vertices);
        let copied = (lists + size_of_val(near) + size_of_val(spare)) as u64;
        Ok(Drawn { near, spare, listed: self.listed(input.trims), copied })
    }

    /// As if its device had been lost.
    #[cfg(test)]
    pub(crate) fn lose(&mut self) {
        self.recorder.lose();
    }

    pub(super) fn check_size(&self, [width, height]: [u32; 2]) -> Result<(), VulkanError> {
        self.recorder.check()?;
        let device = &self.recorder.device;
        if width.max(height) > device.largest {
            let (limit, device) = (device.largest, device.found.name.clone());
            return Err(VulkanError::ImageTooLarge { width, height, limit, device });
        }
        Ok(())
    }

    /// Draws a frame to its end.
    pub(super) fn run(&mut self, frame: &Frame, order: &Order) -> Result<(), VulkanError> {
        let pipelines = &self.pipelines;
        self.recorder.run_in_order("drawing meshlets", order, |recorder| On { recorder, pipelines }.record(frame))
    }

    /// False, and more room for the next time, where a frame listed more fragments than there was room for.
    pub(super) fn lists_fit(&mut self, lists: Option<&Arc<TrimLists>>) -> Result<bool, VulkanError> {
        let trims = self.buffers.trims.as_mut().filter(|_| lists.is_some());
        trims.map_or(Ok(true), |trims| trims.has_room(&self.recorder.device))
    }

    /// What the last frame listed.
    pub(super) fn listed(&self, lists: Option<&Arc<TrimLists>>) -> &[abi::Fragment] {
        let trims = self.buffers.trims.as_ref().filter(|_| lists.is_some());
        trims.map_or(&[], Trims::found)
    }

    /// What shaders are told of a picture, without any lists.
    pub(super) fn push(&self, size: [u32; 2]) -> Push {
        let half_viewport = self.recorder.device.half_viewport;
        Push {
            size,
            middle: jobs::middle(size),
            half_viewport: half_viewport as i32,
            scale: 1.0 / half_viewport as f32,
            ..Push::default()
        }
    }

    /// What a device that lists workgroups itself is told.
    pub(crate) fn wanted(&self, fill: Fill, size: [u32; 2]) -> Wanted {
        Wanted::new(fill, size, self.recorder.device.half_viewport as i32)
    }

    /// Tells shaders a scene's trees: what push constants name, what is 0 first, and what the host reads then.
    pub(super) fn tell_trims(
        &mut self,
        lists: &Arc<TrimLists>,
        alone: bool,
    ) -> Result<(u64, vk::Buffer, [Copy; 2]), VulkanError> {
        self.pipelines.make(true)?;
        let trims = Trims::of(&self.recorder.device, &mut self.buffers.trims, lists)?;
        let told = trims.tell(alone);
        let (count, listed) = (size_of::<u64>() as u64, trims.listed.bytes());
        let copies = [
            Copy::new(trims.count.raw, trims.counted.raw, count),
            Copy::new(trims.queue.raw, trims.listed.raw, listed),
        ];
        Ok((told, trims.count.raw, copies))
    }

    fn upload(&mut self, input: &Input) -> Result<Frame<'static>, VulkanError> {
        let mut push = self.push(input.size);
        let Self { buffers, recorder, .. } = self;
        let device = &recorder.device;
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
            Copy::new(near.raw, room(device, near_words, bytes, Use::Download)?.raw, bytes),
            Copy::new(spare.raw, room(device, spare_words, bytes, Use::Download)?.raw, bytes),
        ];
        let mut clears: Vec<vk::Buffer> = copies.iter().map(|copy| copy.from).collect();
        if let Some(lists) = input.trims {
            let (told, count, lists) = self.tell_trims(lists, input.alone)?;
            push.trims = told;
            clears.push(count);
            copies.extend(lists);
        }
        Ok(Frame { size: input.size, fill: input.fill, push, draws, clears, copies, shared: Vec::new() })
    }
}

/// What frames are recorded with.
struct On<'a> {
    recorder: &'a Recorder,
    pipelines: &'a Pipelines,
}

impl On<'_> {
    fn record(&self, frame: &Frame) {
        let shaders = vk::PipelineStageFlags2::MESH_SHADER_EXT | vk::PipelineStageFlags2::FRAGMENT_SHADER;
        let recorder = self.recorder;
        recorder.acquire(&frame.shared, shaders);
        // The queue of fragments may keep what it had: its count says how many there are.
        for &buffer in &frame.clears {
            let (raw, commands) = (&recorder.device.raw, recorder.commands);
            // SAFETY: commands are being recorded; the buffers live until the next frame's are made, after this one.
            unsafe { raw.cmd_fill_buffer(commands, buffer, 0, vk::WHOLE_SIZE, 0) };
        }
        recorder.barrier(vk::PipelineStageFlags2::CLEAR, vk::PipelineStageFlags2::FRAGMENT_SHADER);
        let [near, spare] = jobs::passes(frame.fill);
        self.pass(frame, near);
        recorder.barrier(vk::PipelineStageFlags2::FRAGMENT_SHADER, vk::PipelineStageFlags2::FRAGMENT_SHADER);
        self.pass(frame, spare);
        recorder.barrier(vk::PipelineStageFlags2::FRAGMENT_SHADER, vk::PipelineStageFlags2::COPY);
        recorder.copy(&frame.copies);
        recorder.barrier(vk::PipelineStageFlags2::COPY, vk::PipelineStageFlags2::HOST);
        recorder.release(&frame.shared, shaders);
    }

    /// All that is drawn before anybody looks at it.
    fn pass(&self, frame: &Frame, kinds: &[Kind]) {
        let (raw, commands, [width, height]) = (&self.recorder.device.raw, self.recorder.commands, frame.size);
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
        let (raw, commands) = (&self.recorder.device.raw, self.recorder.commands);
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
                self.recorder.device.mesh.cmd_draw_mesh_tasks(commands, count.min(MOST_GROUPS), rows, 1);
            }
        }
    }
}

impl Drop for Rasterizer {
    fn drop(&mut self) {
        // Fields are dropped after this: nothing uses their buffers and pipelines any more.
        self.recorder.device.wait_idle();
    }
}

impl std::fmt::Debug for Rasterizer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Rasterizer").field(&self.recorder.device).finish()
    }
}

/// Shaders read what lists say: all of it must be there.
fn check(input: &Input) -> Result<(), VulkanError> {
    let bad = |meshlet: usize, reason| VulkanError::BadMeshlet { meshlet, reason };
    for (k, m) in input.meshlets.iter().enumerate() {
        let count = m.quads.iter().map(|&n| usize::from(n) + 1).product::<usize>();
        if m.quads.iter().any(|n| !(1..abi::MESHLET_VERTICES as u8).contains(n)) {
            return Err(bad(k, "it has no quads, or more than 7 along a side"));
        }
        if m.patch as usize >= input.patches.len().min(input.leaves.len()) {
            return Err(bad(k, "its patch is not in the lists"));
        }
        if m.vertices as usize + count > input.vertices.len() {
            return Err(bad(k, "its vertices end beyond the list"));
        }
    }
    for &number in input.numbers {
        let Some(m) = input.meshlets.get(number as usize) else {
            return Err(bad(number as usize, "there is no such meshlet"));
        };
        let trees = input.trims.map_or(0, |trims| trims.trees.len());
        if m.tested != 0 && input.leaves[m.patch as usize].tree as usize >= trees {
            return Err(bad(number as usize, "its trims are not in the list"));
        }
    }
    Ok(())
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
        // What is to spare may be too much.
        *kept = Some(Buffer::new(device, more, used).or_else(|_| Buffer::new(device, bytes, used))?);
    }
    Ok(kept.as_mut().expect("it was made above"))
}

/// The same with values; their address.
fn filled<T: Pod>(device: &Arc<Device>, kept: &mut Option<Buffer>, values: &[T]) -> Result<u64, VulkanError> {
    let buffer = room(device, kept, size_of_val(values) as u64, Use::Upload)?;
    buffer.write(values.iter().copied());
    Ok(buffer.address)
}
