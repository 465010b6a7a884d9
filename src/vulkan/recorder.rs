//! One list of commands: recorded, run to its end, and timed by the device's own clock.

use super::rasterize::TIMEOUT;
use super::{Device, Order, Semaphores, SharedBuffer, SharedSemaphore, VulkanError};
use crate::report::Spread;
use ash::vk;
use std::sync::{Arc, PoisonError};

/// Records commands and waits for them.
pub(super) struct Recorder {
    pub commands: vk::CommandBuffer,
    pool: vk::CommandPool,
    done: vk::Fence,
    /// Two timestamps; null where the queue has none.
    queries: vk::QueryPool,
    /// What went wrong: commands may still run, so nothing is recorded any more.
    failed: Option<VulkanError>,
    pub device: Arc<Device>,
}

/// A copy from one buffer to another.
pub(super) struct Copy {
    pub from: vk::Buffer,
    pub to: vk::Buffer,
    pub regions: Vec<vk::BufferCopy>,
}

impl Copy {
    /// Of the first bytes.
    pub fn new(from: vk::Buffer, to: vk::Buffer, bytes: u64) -> Self {
        Self { from, to, regions: vec![vk::BufferCopy::default().size(bytes)] }
    }
}

impl Recorder {
    pub fn new(device: Arc<Device>) -> Result<Self, VulkanError> {
        let mut made = Self {
            commands: vk::CommandBuffer::null(),
            pool: vk::CommandPool::null(),
            done: vk::Fence::null(),
            queries: vk::QueryPool::null(),
            failed: None,
            device,
        };
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(made.device.family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        let queries = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
        let raw = &made.device.raw;
        // SAFETY: the family is the queue's; the pool lives as long as what is made of it; timestamps are asked for only where
        // there are any. `drop` destroys what was made until a call fails.
        unsafe {
            made.pool = raw.create_command_pool(&pool, None).map_err(VulkanError::of("vkCreateCommandPool"))?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(made.pool).command_buffer_count(1);
            let all = raw.allocate_command_buffers(&info);
            made.commands = all.map_err(VulkanError::of("vkAllocateCommandBuffers"))?[0];
            let fence = raw.create_fence(&vk::FenceCreateInfo::default(), None);
            made.done = fence.map_err(VulkanError::of("vkCreateFence"))?;
            if made.device.timestamps.is_some() {
                let pool = raw.create_query_pool(&queries, None);
                made.queries = pool.map_err(VulkanError::of("vkCreateQueryPool"))?;
            }
        }
        Ok(made)
    }

    /// As if the device had been lost.
    #[cfg(test)]
    pub fn lose(&mut self) {
        self.failed = Some(VulkanError::Lost { what: "drawing meshlets" });
    }

    /// Runs what `record` records, to its end. `what`: for errors.
    pub fn run(&mut self, what: &'static str, record: impl FnOnce(&Self)) -> Result<(), VulkanError> {
        self.run_in_order(what, &Order::default(), record)
    }

    /// The same after what others do, and before what they wait to do.
    pub fn run_in_order(
        &mut self,
        what: &'static str,
        order: &Order,
        record: impl FnOnce(&Self),
    ) -> Result<(), VulkanError> {
        self.check()?;
        let result = self.run_once(what, order, record);
        self.failed = result.clone().err();
        let late = matches!(result, Err(VulkanError::Call { code: vk::Result::TIMEOUT, .. }));
        if let Some((semaphore, value)) = order.wait.filter(|(s, _)| late && s.kind() == Semaphores::Timeline) {
            // Who should have signalled it has not: without that the device would never be idle again.
            let _ = semaphore.signal(value);
        }
        result
    }

    /// Refuses where something went wrong before: buffers may still be in use.
    pub fn check(&self) -> Result<(), VulkanError> {
        self.failed.clone().map_or(Ok(()), Err)
    }

    fn run_once(&self, what: &'static str, order: &Order, record: impl FnOnce(&Self)) -> Result<(), VulkanError> {
        let raw = &self.device.raw;
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: what ran before is done, or `failed` would have kept us out.
        unsafe { raw.begin_command_buffer(self.commands, &once) }.map_err(VulkanError::of("vkBeginCommandBuffer"))?;
        record(self);
        let all = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
        let (waits, signals) = (point(order.wait), point(order.signal));
        let submits = [vk::SubmitInfo2::default()
            .command_buffer_infos(&all)
            .wait_semaphore_infos(waits.as_slice())
            .signal_semaphore_infos(signals.as_slice())];
        // SAFETY: the commands were begun above; the fence is not signalled, the queue is locked, and the semaphores live until
        // all has run.
        unsafe {
            raw.end_command_buffer(self.commands).map_err(VulkanError::of("vkEndCommandBuffer"))?;
            let queue = self.device.queue.lock().unwrap_or_else(PoisonError::into_inner);
            raw.queue_submit2(*queue, &submits, self.done).map_err(VulkanError::of("vkQueueSubmit2"))?;
            drop(queue);
            raw.wait_for_fences(&[self.done], true, TIMEOUT).map_err(VulkanError::of(what))?;
            raw.reset_fences(&[self.done]).map_err(VulkanError::of("vkResetFences"))
        }
    }

    /// Runs what `record` records once to warm up and then `rounds` times; milliseconds of a round. At least one round.
    pub fn time(&mut self, what: &'static str, rounds: u32, record: impl Fn(&Self)) -> Result<Spread, VulkanError> {
        if self.device.timestamps.is_none() {
            return Err(VulkanError::NoTimestamps { device: self.device.found.name.clone() });
        }
        self.run(what, &record)?;
        let mut times = Vec::new();
        for _ in 0..rounds.max(1) {
            self.run(what, |recorder| recorder.between_timestamps(&record))?;
            times.push(self.elapsed()?);
        }
        times.sort_by(f64::total_cmp);
        let middle = times.len() / 2;
        let median = if times.len() % 2 == 1 { times[middle] } else { 0.5 * (times[middle - 1] + times[middle]) };
        Ok(Spread { median, min: times[0], max: times[times.len() - 1] })
    }

    fn between_timestamps(&self, record: impl Fn(&Self)) {
        let (raw, commands) = (&self.device.raw, self.commands);
        // All that came before is done, and all of `record` is: nothing else is in between.
        let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
        // SAFETY: commands are being recorded, outside of rendering; `time` has seen that there are timestamps.
        unsafe {
            raw.cmd_reset_query_pool(commands, self.queries, 0, 2);
            raw.cmd_write_timestamp2(commands, stage, self.queries, 0);
        }
        record(self);
        // SAFETY: as above.
        unsafe { raw.cmd_write_timestamp2(commands, stage, self.queries, 1) };
    }

    /// Milliseconds between the timestamps of the last run.
    fn elapsed(&self) -> Result<f64, VulkanError> {
        let Some(clock) = self.device.timestamps else { return Ok(0.0) };
        let mut ticks = [0u64; 2];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: both timestamps have been written: the commands are done.
        let got = unsafe { self.device.raw.get_query_pool_results(self.queries, 0, &mut ticks, flags) };
        got.map_err(VulkanError::of("vkGetQueryPoolResults"))?;
        // The count starts again where its bits end.
        let ticks = ticks[1].wrapping_sub(ticks[0]) & (u64::MAX >> (64 - clock.bits.min(64)));
        Ok(ticks as f64 * f64::from(clock.period) * 1e-6)
    }

    /// What comes after sees what was written before.
    pub fn barrier(&self, before: vk::PipelineStageFlags2, after: vk::PipelineStageFlags2) {
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(before)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(after)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: commands are being recorded, outside of rendering.
        unsafe { self.device.raw.cmd_pipeline_barrier2(self.commands, &info) };
    }

    /// Takes over buffers that other APIs may have written.
    pub fn acquire(&self, buffers: &[&SharedBuffer], after: vk::PipelineStageFlags2) {
        self.hand_over(buffers, |barrier, ours| {
            barrier
                .src_queue_family_index(vk::QUEUE_FAMILY_EXTERNAL)
                .dst_queue_family_index(ours)
                .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
                .dst_stage_mask(after)
                .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        });
    }

    /// Leaves them to others.
    pub fn release(&self, buffers: &[&SharedBuffer], before: vk::PipelineStageFlags2) {
        self.hand_over(buffers, |barrier, ours| {
            barrier
                .src_queue_family_index(ours)
                .dst_queue_family_index(vk::QUEUE_FAMILY_EXTERNAL)
                .src_stage_mask(before)
                .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        });
    }

    fn hand_over<'b>(
        &self,
        buffers: &[&SharedBuffer],
        how: impl Fn(vk::BufferMemoryBarrier2<'b>, u32) -> vk::BufferMemoryBarrier2<'b>,
    ) {
        let barrier = |shared: &&SharedBuffer| {
            let all = vk::BufferMemoryBarrier2::default().buffer(shared.buffer.raw).size(vk::WHOLE_SIZE);
            how(all, self.device.family)
        };
        let barriers: Vec<_> = buffers.iter().map(barrier).collect();
        let info = vk::DependencyInfo::default().buffer_memory_barriers(&barriers);
        // SAFETY: commands are being recorded, outside of rendering; the buffers live until they have run.
        unsafe { self.device.raw.cmd_pipeline_barrier2(self.commands, &info) };
    }

    pub fn copy(&self, copies: &[Copy]) {
        for Copy { from, to, regions } in copies.iter().filter(|copy| !copy.regions.is_empty()) {
            // SAFETY: commands are being recorded; both buffers live until they have run and have room for the regions.
            unsafe { self.device.raw.cmd_copy_buffer(self.commands, *from, *to, regions) };
        }
    }
}

/// A point in another's order.
fn point(of: Option<(&SharedSemaphore, u64)>) -> Option<vk::SemaphoreSubmitInfo<'static>> {
    let (semaphore, value) = of?;
    let all = vk::PipelineStageFlags2::ALL_COMMANDS;
    Some(vk::SemaphoreSubmitInfo::default().semaphore(semaphore.raw).value(value).stage_mask(all))
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let raw = &self.device.raw;
        self.device.wait_idle();
        // SAFETY: nothing runs once the wait returns; all three are this recorder's own, or null.
        unsafe {
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_fence(self.done, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}
