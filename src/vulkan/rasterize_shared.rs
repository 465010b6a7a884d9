//! rasterize: the same from lists that another device has written, in memory that both see.

use super::jobs::Jobs;
use super::rasterize::{Frame, Rasterizer};
use super::{Order, SharedBuffer, VulkanError};
use crate::cuda::{TrimLists, abi};
use crate::stages::Fill;
use std::sync::Arc;

/// A frame's lists, those of `kernels/abi.h`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SharedInput<'a> {
    pub size: [u32; 2],
    pub fill: Fill,
    pub patches: &'a SharedBuffer,
    pub leaves: &'a SharedBuffer,
    pub meshlets: &'a SharedBuffer,
    /// How many meshlets there are.
    pub all: u32,
    pub vertices: &'a SharedBuffer,
    /// The workgroups, and where they are in that list.
    pub listed: &'a SharedBuffer,
    pub jobs: &'a Jobs,
    /// Words; what is drawn is added to what they have.
    pub near: &'a SharedBuffer,
    pub spare: &'a SharedBuffer,
    /// As `Input` has them.
    pub trims: Option<&'a Arc<TrimLists>>,
    pub alone: bool,
    /// What the other device signals once it has written all that.
    pub order: Order<'a>,
}

impl Rasterizer {
    /// Draws meshlets into the other device's words; returns fragments that only the exact surface can decide.
    pub(crate) fn draw_shared(&mut self, input: &SharedInput) -> Result<&[abi::Fragment], VulkanError> {
        self.check_size(input.size)?;
        let mut order = input.order;
        loop {
            let frame = self.shared_frame(input)?;
            self.run(&frame, &order)?;
            // The other device is waited for once. What is drawn again is the same.
            order = Order::default();
            if self.lists_fit(input.trims)? {
                return Ok(self.listed(input.trims));
            }
        }
    }

    fn shared_frame<'a>(&mut self, input: &SharedInput<'a>) -> Result<Frame<'a>, VulkanError> {
        let SharedInput { size, fill, patches, leaves, meshlets, vertices, listed, near, spare, .. } = *input;
        let mut push = self.push(size);
        push.all = input.all;
        let lists = [
            (&mut push.patches, patches),
            (&mut push.leaves, leaves),
            (&mut push.meshlets, meshlets),
            (&mut push.vertices, vertices),
            (&mut push.numbers, listed),
            (&mut push.near, near),
            (&mut push.spare, spare),
        ];
        let shared = lists.into_iter().map(|(address, buffer)| {
            *address = buffer.address();
            buffer
        });
        let shared = shared.collect();
        let (mut clears, mut copies) = (Vec::new(), Vec::new());
        if let Some(lists) = input.trims {
            let (told, count, lists) = self.tell_trims(lists, input.alone)?;
            push.trims = told;
            clears.push(count);
            copies.extend(lists);
        }
        Ok(Frame { size, fill, push, draws: input.jobs.draws.clone(), clears, copies, shared })
    }
}
