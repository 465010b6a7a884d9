//! Trim trees in a device's memory, for `kernels/trim_tree.cuh`.

use super::gpu::pods;
use super::{Buffer, Gpu, GpuError, Pointer, abi};
use crate::scene::{Clip, Exit, Node, Segment, Tree, Trims};
use glam::DVec3;

/// The lists of all trim trees; a tree's number is that of `PatchTrim::tree`.
#[derive(Clone, Copy, Debug)]
pub struct TrimsOnDevice {
    trees: Buffer<abi::TrimTree>,
    nodes: Buffer<abi::TrimNode>,
    clips: Buffer<abi::TrimClip>,
    segments: Buffer<abi::TrimSegment>,
    points: Buffer<abi::TrimPoint>,
}

/// What kernels get of them: `trims::Trims`. Textures are null but by `--trim texture`, and words of all textures with them.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct TrimPointers {
    trees: Pointer<abi::TrimTree>,
    nodes: Pointer<abi::TrimNode>,
    clips: Pointer<abi::TrimClip>,
    segments: Pointer<abi::TrimSegment>,
    points: Pointer<abi::TrimPoint>,
    textures: Pointer<abi::TrimTexture>,
    texels: Pointer<u32>,
}

pods!(abi::TrimTree abi::TrimNode abi::TrimClip abi::TrimSegment abi::TrimPoint TrimPointers);

impl TrimPointers {
    /// With a frame's textures, by leaf.
    pub(super) fn with_textures(self, textures: &Buffer<abi::TrimTexture>, texels: &Buffer<u32>) -> Self {
        Self { textures: textures.pointer(), texels: texels.pointer(), ..self }
    }
}

/// The lists of all trim trees as devices have them.
#[derive(Clone, Debug, Default)]
pub struct TrimLists {
    pub trees: Vec<abi::TrimTree>,
    pub nodes: Vec<abi::TrimNode>,
    pub clips: Vec<abi::TrimClip>,
    pub segments: Vec<abi::TrimSegment>,
    pub points: Vec<abi::TrimPoint>,
}

impl TrimLists {
    pub fn new(trims: &Trims) -> Self {
        let point = |p: &DVec3| abi::TrimPoint { x: p.x, y: p.y, w: p.z };
        Self {
            trees: trims.trees.iter().map(tree).collect(),
            nodes: trims.nodes.iter().map(node).collect(),
            clips: trims.clips.iter().map(clip).collect(),
            segments: trims.segments.iter().map(segment).collect(),
            points: trims.points.iter().map(point).collect(),
        }
    }
}

impl TrimsOnDevice {
    pub fn upload<G: Gpu>(gpu: &mut G, trims: &Trims) -> Result<Self, GpuError> {
        let lists = TrimLists::new(trims);
        Ok(Self {
            trees: gpu.upload(&lists.trees)?,
            nodes: gpu.upload(&lists.nodes)?,
            clips: gpu.upload(&lists.clips)?,
            segments: gpu.upload(&lists.segments)?,
            points: gpu.upload(&lists.points)?,
        })
    }

    /// What a kernel gets.
    pub fn pointers(&self) -> TrimPointers {
        TrimPointers {
            trees: self.trees.pointer(),
            nodes: self.nodes.pointer(),
            clips: self.clips.pointer(),
            segments: self.segments.pointer(),
            points: self.points.pointer(),
            textures: Pointer::NULL,
            texels: Pointer::NULL,
        }
    }

    pub fn free<G: Gpu>(self, gpu: &mut G) -> Result<(), GpuError> {
        gpu.free(self.trees)?;
        gpu.free(self.nodes)?;
        gpu.free(self.clips)?;
        gpu.free(self.segments)?;
        gpu.free(self.points)
    }
}

fn tree(tree: &Tree) -> abi::TrimTree {
    let Tree { root, bounds, gap } = *tree;
    abi::TrimTree { low: bounds.low, high: bounds.high, gap, root, unused: 0 }
}

fn clip(clip: &Clip) -> abi::TrimClip {
    let exit = match clip.exit {
        None => abi::EXIT_NONE,
        Some(Exit::Lower) => abi::EXIT_LOWER,
        Some(Exit::Upper) => abi::EXIT_UPPER,
    };
    abi::TrimClip { heights: clip.heights, segment: clip.segment, exit }
}

fn segment(segment: &Segment) -> abi::TrimSegment {
    let Segment { ends, gap, first, count } = *segment;
    abi::TrimSegment { ends, gap, first, count }
}

fn node(node: &Node) -> abi::TrimNode {
    match *node {
        Node::Split { axis, at, children } => abi::TrimNode { at, first: children, tag: axis.into() },
        Node::Cell { first, count, inside } => {
            let inside = if inside { abi::NODE_INSIDE } else { 0 };
            abi::TrimNode { at: 0.0, first, tag: abi::NODE_CELL | inside | count << abi::NODE_COUNT_SHIFT }
        }
    }
}
