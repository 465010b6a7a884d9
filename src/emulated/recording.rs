//! What a device was asked for and what came of it, as bytes. `kernels/host/selftest/replay.cpp` does the same again without
//! Rust, so that a sanitizer sees kernels and nothing else.
//!
//! One event follows the other; numbers are little-endian, lists begin with their length in 32 bits.
//!
//! | first byte | then |
//! |---|---|
//! | `A` | a new allocation: its address as kernels get it, its length (64 bits each), the byte it is filled with |
//! | `W` | new contents: the allocation's number (32 bits), its bytes |
//! | `F` | the number of an allocation that is freed |
//! | `L` | a launch: the kernel's name, `hp_launch` of kernels/host/api.h, a list of arguments, each a list of bytes, and a list of all allocations afterwards: number, hash (64 bits) |

use super::schedule::Schedule;
use crate::cuda::Shape;
use std::sync::{Arc, Mutex, PoisonError};

/// A handle: it is filled while a device works.
#[derive(Clone, Debug, Default)]
pub struct Recording(Arc<Mutex<Vec<u8>>>);

impl Recording {
    /// All events so far.
    pub fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn push(&self, parts: &[&[u8]]) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        parts.iter().for_each(|part| all.extend_from_slice(part));
    }

    pub(super) fn allocated(&self, bits: u64, bytes: usize, fill: u8) {
        self.push(&[b"A", &bits.to_le_bytes(), &(bytes as u64).to_le_bytes(), &[fill]]);
    }

    pub(super) fn written(&self, number: usize, contents: &[u8]) {
        self.push(&[b"W", &(number as u32).to_le_bytes(), contents]);
    }

    pub(super) fn freed(&self, number: usize) {
        self.push(&[b"F", &(number as u32).to_le_bytes()]);
    }

    pub(super) fn launched<'m>(
        &self,
        kernel: &str,
        shape: &Shape,
        schedule: &Schedule,
        arguments: &[&[u8]],
        after: impl Iterator<Item = (usize, &'m [u8])>,
    ) {
        let mut launch = Vec::new();
        for number in shape.grid.iter().chain(&shape.block).chain([&shape.dynamic_bytes, &schedule.seed]) {
            launch.extend_from_slice(&number.to_le_bytes());
        }
        let Schedule { lanes, warps, blocks, tensor_cores, .. } = *schedule;
        launch.extend_from_slice(&[lanes as u8, warps as u8, blocks as u8, tensor_cores as u8]);
        self.push(&[b"L", &length(kernel.len()), kernel.as_bytes(), &launch, &length(arguments.len())]);
        arguments.iter().for_each(|argument| self.push(&[&length(argument.len()), argument]));
        let after: Vec<(usize, u64)> = after.map(|(number, contents)| (number, hash(contents))).collect();
        self.push(&[&length(after.len())]);
        after.iter().for_each(|(number, hash)| self.push(&[&length(*number), &hash.to_le_bytes()]));
    }
}

fn length(number: usize) -> [u8; 4] {
    (number as u32).to_le_bytes()
}

/// FNV-1a, but by words of eight bytes; the last one filled up with zeros.
fn hash(contents: &[u8]) -> u64 {
    contents.chunks(8).fold(0xcbf2_9ce4_8422_2325, |hash, part| {
        let mut word = [0; 8];
        word[..part.len()].copy_from_slice(part);
        (hash ^ u64::from_le_bytes(word)).wrapping_mul(0x100_0000_01b3)
    })
}
