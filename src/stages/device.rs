//! The frame on a device: its geometry culled and estimated here, all else by the kernels of `cuda` (staged).

use super::fill::Filled;
use super::frame::{Frame, Geometry, RenderError, Renderer, Targets};
use super::lens::Lens;
use super::shade::{Shader, repaint};
use super::stats::{Clock, Stats};
use super::{Options, Show, Trim, TrimCounts};
use crate::cuda::trims::TrimsOnDevice;
use crate::cuda::{self, Gpu, frame};
use crate::emulated;
use crate::scene::Camera;

/// What draws frames.
#[derive(Debug, Default)]
pub enum Engine {
    /// The reference.
    #[default]
    Cpu,
    /// The GPU's kernels, run on the CPU.
    Emulated(Box<emulated::Device>),
    /// An NVIDIA GPU.
    Cuda(Box<cuda::Stream>),
}

impl Engine {
    /// As `--backend` names it.
    pub fn name(&self) -> &'static str {
        match self {
            Engine::Cpu => "cpu",
            Engine::Emulated(_) => "emulated",
            Engine::Cuda(_) => "cuda",
        }
    }

    /// The GPU and its driver; `None` on the CPU.
    pub fn gpu(&self) -> Option<String> {
        match self {
            Engine::Cpu | Engine::Emulated(_) => None,
            Engine::Cuda(stream) => Some(stream.name().to_owned()),
        }
    }
}

impl Renderer<'_> {
    /// A frame by a device's kernels; its words are those of the CPU.
    pub(super) fn render_on<G: Gpu>(
        &mut self,
        gpu: &mut G,
        camera: &Camera,
        options: &Options,
    ) -> Result<Frame, RenderError> {
        if options.trim == Trim::Texture {
            return Err(RenderError::NoTextures);
        }
        let lens = Lens::new(camera);
        let mut clock = Clock::new();
        let culled = self.cull(&lens, options)?;
        clock.stage("cull");
        let Geometry { leaves, grids } = self.estimate(&lens, options, culled)?;
        clock.stage("estimate");
        let meshlets = self.evaluate(&lens, options, &leaves, &grids)?;
        let staged = self.staged_of(&lens, options, &leaves, &grids, &meshlets);
        let doubtful = self.scene.trims.segments() > 0;
        let trims = match self.resident {
            Some(trims) => trims,
            None => *self.resident.insert(TrimsOnDevice::upload(gpu, &self.scene.trims)?),
        };
        let drawn = frame::draw(gpu, &staged, &trims, doubtful, &mut |stage| clock.stage(stage))?;
        let mut targets = Targets::of(drawn.near, drawn.parameters, drawn.color);
        let filled = drawn.filled.iter().map(|&pixel| Filled { pixel, near: 0, start: None }).collect::<Vec<_>>();
        if options.show != Show::Shaded {
            let as_it_is = Options { refine: 0, ..*options };
            let shader = Shader {
                scene: self.scene,
                lens: &lens,
                options: &as_it_is,
                meshlets: &meshlets,
                leaves: &leaves.leaves,
                nets: &leaves.nets,
                grids: &grids,
                textures: Vec::new(),
            };
            repaint(&shader, &mut targets);
        }
        let meshlets_boundary = meshlets.meshlets.iter().filter(|m| m.tested).count() as u64;
        let stats = Stats {
            stages: clock.stages(),
            patches: self.scene.instances.iter().map(|i| i.patches.len() as u64).sum(),
            patches_visible: leaves.patches_visible,
            leaves: leaves.leaves.len() as u64,
            meshlets: meshlets.meshlets.len() as u64,
            quads: meshlets.quads,
            triangles: 2 * meshlets.quads,
            filled: filled.len() as u64,
            drawn: targets.near.iter().filter(|&&word| word != 0).count() as u64,
            trim: meshlets.trim.plus(drawn.trim).plus(TrimCounts { meshlets_boundary, ..TrimCounts::default() }),
            buffer_bytes: drawn.buffer_bytes,
        };
        let (camera, options, leaves) = (*camera, *options, leaves.leaves);
        Ok(Frame { camera, options, stats, targets, leaves, grids, meshlets, filled })
    }
}
