//! The frame on a device, by the kernels of `cuda`.

use super::device_geometry::{DeviceGeometry, GeometryCounts};
use super::fill::Filled;
use super::frame::{Frame, Geometry, RenderError, Renderer, Surface, Targets};
use super::lens::Lens;
use super::shade::{Shader, repaint};
use super::stats::{Clock, Stats};
use super::{Options, Show, Trim, TrimCounts};
use crate::cuda::evaluate::view;
use crate::cuda::frame::Input;
use crate::cuda::scene::SceneOnDevice;
use crate::cuda::session::{self as device, Session};
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
        let scene = match self.resident {
            Some(scene) => scene,
            None => *self.resident.insert(SceneOnDevice::upload(gpu, self.scene)?),
        };
        let mut session = Session::new(gpu);
        let frame = self.frame_in(&mut session, &scene, camera, options);
        session.free()?;
        let mut frame = frame?;
        if options.show != Show::Shaded {
            self.explain(&mut frame)?;
        }
        Ok(frame)
    }

    fn frame_in<G: Gpu>(
        &self,
        session: &mut Session<G>,
        scene: &SceneOnDevice,
        camera: &Camera,
        options: &Options,
    ) -> Result<Frame, RenderError> {
        let mut clock = Clock::new();
        session.begin()?;
        let geometry = self.geometry_on(session, scene, camera, options, &mut |stage| clock.stage(stage))?;
        let GeometryCounts { patches_visible, quads, meshlets_outside, meshlets_inside, meshlets_boundary } =
            geometry.counts();
        let DeviceGeometry { leaves, meshlets } = geometry;
        let input = Input {
            geometry: device::Geometry {
                view: view(&Lens::new(camera), options),
                patches: leaves.patches,
                leaves: leaves.leaves,
                nets: leaves.nets,
                basis: leaves.basis,
                meshlets: meshlets.meshlets,
                vertices: None,
            },
            vertices: meshlets.vertices,
            shape: options.frame,
            trims: scene.trims(),
            trimmed: scene.trimmed,
            textured: options.trim == Trim::Texture,
        };
        let drawn = frame::draw(session, &input, &mut |stage| clock.stage(stage))?;
        let filled = drawn.filled.iter().map(|&pixel| Filled { pixel, near: 0, start: None }).collect::<Vec<_>>();
        let counts = TrimCounts { meshlets_outside, meshlets_inside, meshlets_boundary, ..TrimCounts::default() };
        let stats = Stats {
            stages: clock.stages_by(&session.times()?),
            patches: self.scene.instances.iter().map(|i| i.patches.len() as u64).sum(),
            patches_visible,
            leaves: leaves.patches.len() as u64,
            meshlets: meshlets.meshlets.len() as u64,
            quads,
            triangles: 2 * quads,
            filled: filled.len() as u64,
            drawn: drawn.near.iter().filter(|&&word| word != 0).count() as u64,
            trim: drawn.trim.plus(counts),
            buffer_bytes: drawn.buffer_bytes,
        };
        let targets = Targets::of(drawn.near, drawn.parameters, drawn.color);
        let surface = Surface::Pixels(drawn.shown);
        Ok(Frame { camera: *camera, options: *options, stats, targets, surface, filled })
    }

    /// Paints the pictures that explain a frame: by the CPU, of its own grids, which are the same.
    fn explain(&self, frame: &mut Frame) -> Result<(), RenderError> {
        let lens = Lens::new(&frame.camera);
        let Geometry { leaves, grids } = self.estimate(&lens, &frame.options, self.cull(&lens, &frame.options)?)?;
        let meshlets = self.evaluate(&lens, &frame.options, &leaves, &grids)?;
        let as_it_is = Options { refine: 0, ..frame.options };
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
        repaint(&shader, &mut frame.targets);
        Ok(())
    }
}
