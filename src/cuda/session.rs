//! One frame's use of a device: buffers that are freed together, and launches that all begin with the frame's geometry.

use super::count::{Count, List, Plan, Sizes};
use super::shared::{Role, Shared};
use super::{Argument, Buffer, Gpu, GpuError, Pod, Pointer, Shape, abi};
use crate::stages::STAGES;
use std::collections::VecDeque;

/// Threads a block of kernels that give a thread to each pixel, or to each entry of a list.
pub(crate) const THREADS: u32 = 128;
/// Warps a block of kernels that give a warp to each meshlet.
const WARPS: usize = THREADS as usize / 32;

/// Buffers of one frame.
pub(crate) struct Session<'g, G: Gpu> {
    gpu: &'g mut G,
    /// Where mesh shaders draw a part of the frame, in the same memory.
    pub(super) shared: Option<&'g mut Shared>,
    owned: Vec<Buffer<u8>>,
    /// Where the frame began and its stages ended.
    marks: Vec<G::Mark>,
    /// Ranges that are open for profilers.
    open: usize,
    /// What kernels count, zero at first, and how many of the last buffer are in use.
    pub(super) counters: Vec<Buffer<u64>>,
    pub(super) used: usize,
    /// The same as they were at the frame's end.
    pub(super) found: Option<Vec<Vec<u64>>>,
    pub(super) sizes: Sizes,
    /// Lists that have to fit.
    pub(super) counts: Vec<Count>,
    /// Buffers of an earlier frame with the same plan, in the order in which they are wanted.
    kept: VecDeque<Buffer<u8>>,
}

/// What `GEOMETRY` in kernels/topology.cuh names.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Geometry {
    pub view: abi::View,
    pub patches: Buffer<abi::Patch>,
    pub leaves: Buffer<abi::Leaf>,
    pub nets: Buffer<abi::Point>,
    pub basis: Buffer<f32>,
    pub meshlets: List<abi::Meshlet>,
    /// None: evaluated where they are wanted.
    pub vertices: Option<Buffer<abi::Vertex>>,
}

impl<'g, G: Gpu> Session<'g, G> {
    pub fn new(gpu: &'g mut G) -> Self {
        Self::with_plan(gpu, None, Vec::new())
    }

    /// Some of its memory is mesh shaders' too.
    pub fn sharing(gpu: &'g mut G, shared: Option<&'g mut Shared>) -> Self {
        Self { shared, ..Self::new(gpu) }
    }

    /// With room as earlier frames had to ask for, and their buffers.
    pub fn with_plan(gpu: &'g mut G, plan: Option<Plan>, kept: Vec<Buffer<u8>>) -> Self {
        Self {
            gpu,
            shared: None,
            owned: Vec::new(),
            marks: Vec::new(),
            open: 0,
            counters: Vec::new(),
            used: 0,
            found: None,
            sizes: Sizes::of(plan),
            counts: Vec::new(),
            kept: kept.into(),
        }
    }

    /// A buffer of the same frame before, if it is as large.
    fn kept<T: Pod>(&mut self, length: usize) -> Option<Buffer<T>> {
        let buffer = self.kept.pop_front()?;
        if buffer.len() == length * size_of::<T>() {
            return Some(buffer.of());
        }
        self.kept.push_front(buffer);
        None
    }

    fn own<T: Pod>(&mut self, buffer: Buffer<T>) -> Buffer<T> {
        self.owned.push(buffer.bytes());
        buffer
    }

    pub fn allocate<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        let buffer = match self.kept(length) {
            Some(kept) => kept,
            None => self.gpu.allocate(length)?,
        };
        Ok(self.own(buffer))
    }

    pub fn zeroed<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        let buffer = match self.kept(length) {
            Some(kept) => {
                self.gpu.clear(&kept)?;
                kept
            }
            None => self.gpu.zeroed(length)?,
        };
        Ok(self.own(buffer))
    }

    /// Room that mesh shaders see too, where they draw.
    pub fn allocate_as<T: Pod>(&mut self, role: Role, length: usize) -> Result<Buffer<T>, GpuError> {
        match &mut self.shared {
            Some(shared) => shared.room(self.gpu, role, length),
            None => self.allocate(length),
        }
    }

    /// The same with every byte 0.
    pub fn zeroed_as<T: Pod>(&mut self, role: Role, length: usize) -> Result<Buffer<T>, GpuError> {
        if self.shared.is_none() {
            return self.zeroed(length);
        }
        let buffer = self.allocate_as(role, length)?;
        self.gpu.clear(&buffer)?;
        Ok(buffer)
    }

    /// Once all that was launched has ended, `draw` has the memory that both see, where there is any.
    pub fn hand_over<R>(&mut self, draw: impl FnOnce(&Shared) -> Result<R, GpuError>) -> Result<Option<R>, GpuError> {
        let Some(shared) = self.shared.as_deref_mut() else { return Ok(None) };
        shared.hand_over(self.gpu)?;
        draw(shared).map(Some)
    }

    pub fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Buffer<T>, GpuError> {
        self.gpu.upload(data).map(|b| self.own(b))
    }

    pub fn download<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<Vec<T>, GpuError> {
        self.gpu.download(buffer)
    }

    pub fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        self.gpu.launch(kernel, shape, arguments)
    }

    /// A thread for each of `count`; nothing where there is none.
    pub fn for_each(&mut self, kernel: &str, count: usize, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        if count == 0 {
            return Ok(());
        }
        self.gpu.launch(kernel, Shape::of(count, THREADS), arguments)
    }

    /// A thread for each entry that a list has room for.
    pub fn for_all(&mut self, kernel: &str, count: Count, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        self.for_each(kernel, count.room(), arguments)
    }

    /// The same of a kernel that is given the geometry before all else.
    pub fn for_each_in(
        &mut self,
        geometry: &Geometry,
        kernel: &str,
        count: usize,
        rest: &[&dyn Argument],
    ) -> Result<(), GpuError> {
        geometry.with(rest, |arguments| self.for_each(kernel, count, arguments))
    }

    /// So many blocks of a kernel that is given the geometry and the number of meshlets before all else.
    pub fn blocks(
        &mut self,
        geometry: &Geometry,
        kernel: &str,
        blocks: usize,
        rest: &[&dyn Argument],
    ) -> Result<(), GpuError> {
        let mut all: Vec<&dyn Argument> = vec![&geometry.meshlets.count];
        all.extend(rest);
        geometry.with(&all, |arguments| self.gpu.launch(kernel, Shape::row(blocks as u32, THREADS), arguments))
    }

    /// A warp for each meshlet, of a kernel that is given the geometry and the number of meshlets before all else.
    pub fn for_meshlets(&mut self, geometry: &Geometry, kernel: &str, rest: &[&dyn Argument]) -> Result<(), GpuError> {
        let blocks = geometry.meshlets.room().div_ceil(WARPS);
        if blocks == 0 {
            return Ok(());
        }
        self.blocks(geometry, kernel, blocks, rest)
    }

    /// Memory that the frame has on the device.
    pub fn bytes(&self) -> u64 {
        let shared = self.shared.as_ref().map_or(0, |shared| shared.bytes());
        self.owned.iter().map(|b| b.len() as u64).sum::<u64>() + shared
    }

    /// From here the first stage is timed. Where all buffers are there, the frame is recorded and run as a whole.
    pub fn begin(&mut self) -> Result<(), GpuError> {
        if !self.kept.is_empty() {
            self.gpu.record()?;
        }
        self.marks = vec![self.gpu.mark()?];
        self.open("frame");
        self.open(STAGES[0]);
        Ok(())
    }

    /// A stage ends, and the next one begins. Where the frame asks for numbers, what was launched has ended.
    pub fn finish(&mut self) -> Result<(), GpuError> {
        self.marks.push(self.gpu.mark()?);
        if self.asks() {
            self.gpu.finish()?;
        }
        self.close();
        if let Some(next) = STAGES.get(self.marks.len() - 1) {
            self.open(next);
        }
        Ok(())
    }

    /// What `work` launches is one group for profilers.
    pub fn group<R>(&mut self, name: &'static str, work: impl FnOnce(&mut Self) -> R) -> R {
        self.open(name);
        let result = work(self);
        self.close();
        result
    }

    pub(super) fn open(&mut self, name: &'static str) {
        self.open += 1;
        self.gpu.open(name);
    }

    pub(super) fn close(&mut self) {
        if self.open > 0 {
            self.open -= 1;
            self.gpu.close();
        }
    }

    /// Milliseconds of each stage since [`Session::begin`], by the device's own clock.
    pub fn times(&mut self) -> Result<Vec<f64>, GpuError> {
        self.marks.windows(2).map(|pair| self.gpu.between(&pair[0], &pair[1])).collect()
    }

    /// Runs what was recorded.
    pub fn run(&mut self) -> Result<(), GpuError> {
        self.gpu.run()
    }

    /// Ends the frame and leaves its buffers to the next one of the same plan.
    pub fn keep(mut self) -> Result<Vec<Buffer<u8>>, GpuError> {
        let owned = std::mem::take(&mut self.owned);
        self.free()?;
        Ok(owned)
    }

    /// Frees everything and ends the frame's ranges; a failed frame's too.
    pub fn free(&mut self) -> Result<(), GpuError> {
        self.gpu.abandon();
        while self.open > 0 {
            self.close();
        }
        let all = self.owned.drain(..).chain(self.kept.drain(..));
        all.into_iter().try_for_each(|buffer| self.gpu.free(buffer))
    }
}

impl Geometry {
    fn with<R>(&self, rest: &[&dyn Argument], launch: impl FnOnce(&[&dyn Argument]) -> R) -> R {
        let (patches, leaves, nets) = (self.patches.pointer(), self.leaves.pointer(), self.nets.pointer());
        let (basis, meshlets) = (self.basis.pointer(), self.meshlets.pointer());
        let vertices = self.vertices.as_ref().map_or(Pointer::NULL, Buffer::pointer);
        let mut all: Vec<&dyn Argument> = vec![&self.view, &patches, &leaves, &nets, &basis, &meshlets, &vertices];
        all.extend(rest);
        launch(&all)
    }
}
