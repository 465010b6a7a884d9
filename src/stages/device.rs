//! The frame on a device, by the kernels of `cuda`.

use super::device_geometry::{DeviceGeometry, GeometryCounts};
use super::error::RenderError;
use super::fill::{Filled, is_tested_alone};
use super::frame::{Frame, Geometry, Renderer, Surface, Targets};
use super::lens::Lens;
use super::shade::{Shader, repaint};
use super::stats::{Clock, Stats};
use super::{FrameShape, Options, Precision, Route, Show, Trim, TrimCounts};
use crate::cuda::count::Plan;
use crate::cuda::evaluate::{memory, view};
use crate::cuda::frame::Input;
use crate::cuda::hardware::Hardware;
use crate::cuda::scene::SceneOnDevice;
use crate::cuda::selection::Clocks;
use crate::cuda::session::Session;
use crate::cuda::shared::Shared;
use crate::cuda::{self, Buffer, Gpu, GpuError, frame, measured};
use crate::emulated::{self, TensorCores};
use crate::scene::Camera;
use crate::vulkan::Rasterizer;
use std::sync::Arc;

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

    /// Of the GPU, or of the tensor cores that are emulated; the CPU is like these.
    pub fn compute_capability(&self) -> [i32; 2] {
        match self {
            Engine::Cpu => TensorCores::default().compute_capability(),
            Engine::Emulated(device) => device.schedule.tensor_cores.compute_capability(),
            Engine::Cuda(stream) => stream.compute_capability(),
        }
    }

    /// What evaluation takes: as it was measured on this GPU, else as computed. Kernels on the CPU never ask what was measured.
    pub(crate) fn clocks(&self) -> Clocks {
        let computed = Clocks::of(self.compute_capability());
        let measured = self.gpu().and_then(|device| measured::stored(&device));
        measured.and_then(|times| computed.measured(&times)).unwrap_or(*computed)
    }

    /// The GPU and its driver; `None` on the CPU.
    pub fn gpu(&self) -> Option<String> {
        match self {
            Engine::Cpu | Engine::Emulated(_) => None,
            Engine::Cuda(stream) => Some(stream.name().to_owned()),
        }
    }
}

/// What a frame leaves to the next one of the same options and size.
#[derive(Debug)]
pub(super) struct Kept {
    key: (Options, [u32; 2]),
    plan: Plan,
    /// Of a frame that went by this plan.
    buffers: Vec<Buffer<u8>>,
}

impl Renderer<'_> {
    /// A frame by a device's kernels; its words are those of the CPU.
    pub(super) fn render_on<G: Gpu>(
        &mut self,
        gpu: &mut G,
        camera: &Camera,
        options: &Options,
    ) -> Result<Frame, RenderError> {
        if options.show != Show::Shaded && options.precision != Precision::F32 {
            return Err(RenderError::NotExplained);
        }
        let scene = match self.resident {
            Some(scene) => scene,
            None => *self.resident.insert(SceneOnDevice::upload(gpu, self.scene)?),
        };
        let (mut frame, kept) = match options.raster.is_hardware() {
            true => (self.frame_with_hardware(gpu, &scene, camera, options)?, None),
            false => self.planned_frame(gpu, &scene, camera, options)?,
        };
        self.kept = kept;
        if options.show != Show::Shaded {
            self.explain(&mut frame)?;
        }
        Ok(frame)
    }

    /// By the plan of the last frame, or by asking for all numbers; with what the next one may go by.
    fn planned_frame<G: Gpu>(
        &mut self,
        gpu: &mut G,
        scene: &SceneOnDevice,
        camera: &Camera,
        options: &Options,
    ) -> Result<(Frame, Option<Kept>), RenderError> {
        let key = (*options, camera.size);
        let (mut earlier, mut buffers) = (None, Vec::new());
        if let Some(kept) = self.kept.take() {
            if kept.key == key {
                (earlier, buffers) = (Some(kept.plan), kept.buffers);
            } else {
                kept.buffers.into_iter().try_for_each(|buffer| gpu.free(buffer))?;
            }
        }
        if let Some(plan) = &earlier {
            let mut session = Session::with_plan(gpu, Some(plan.clone()), buffers);
            if let Ok(Some(frame)) = self.frame_in(&mut session, scene, camera, options, None) {
                return Ok((frame, Some(Kept { key, plan: plan.clone(), buffers: session.keep()? })));
            }
            // Something did not fit; what, and whether it can be had, is asked for.
            session.free()?;
        }
        let mut session = Session::new(gpu);
        let frame = self.frame_in(&mut session, scene, camera, options, None);
        let plan = session.plan();
        session.free()?;
        let frame = frame?.ok_or(RenderError::Gpu(GpuError::Unsettled))?;
        let plan = earlier.map_or(plan.clone(), |earlier| plan.or(&earlier));
        // Sizes of textures are asked for in any case.
        let kept = (options.trim != Trim::Texture).then_some(Kept { key, plan, buffers: Vec::new() });
        Ok((frame, kept))
    }

    /// Large quads by Vulkan's mesh shaders: always in the staged shape, since they draw vertices in memory, and asking for all
    /// numbers, since the host tells Vulkan how many workgroups there are.
    fn frame_with_hardware<G: Gpu>(
        &mut self,
        gpu: &mut G,
        scene: &SceneOnDevice,
        camera: &Camera,
        options: &Options,
    ) -> Result<Frame, RenderError> {
        let options = &Options { frame: options.shape(), ..*options };
        if let Some(kept) = self.kept.take() {
            kept.buffers.into_iter().try_for_each(|buffer| gpu.free(buffer))?;
        }
        let trims = scene.trimmed && options.trim == Trim::On;
        let trims = trims.then(|| self.trim_lists());
        let mut rasterizer = self.take_hardware(gpu.vulkan_uuid())?;
        let large = self.large(options, rasterizer.device());
        let mut hardware = Hardware {
            rasterizer: &mut rasterizer,
            large: large as f32,
            by_edges: options.route == Route::Eter,
            fill: options.fill,
            trims,
            alone: is_tested_alone(options),
        };
        let mut shared = self.shared_with(gpu, hardware.rasterizer)?;
        let mut session = Session::sharing(gpu, shared.as_mut());
        let frame = self.frame_in(&mut session, scene, camera, options, Some(&mut hardware));
        let mut freed = session.free();
        let failed = |e: &RenderError| matches!(e, RenderError::Gpu(GpuError::Vulkan(e)) if e.is_final());
        // After a failure the next frame opens the device anew. What still runs ends before its memory goes.
        self.hardware = (!frame.as_ref().is_err_and(failed)).then_some(rasterizer);
        // Nobody knows how far a failed frame came: what it signalled may wait for somebody.
        match (&frame, shared) {
            (Err(_), Some(shared)) => freed = freed.and(shared.free(gpu)),
            (_, shared) => self.shared = shared,
        }
        let frame = frame?;
        freed?;
        frame.ok_or(RenderError::Gpu(GpuError::Unsettled))
    }

    /// The memory that both devices see; None: they can't share any.
    fn shared_with<G: Gpu>(&mut self, gpu: &mut G, rasterizer: &Rasterizer) -> Result<Option<Shared>, RenderError> {
        let device = rasterizer.device();
        match self.shared.take() {
            Some(shared) if Arc::ptr_eq(shared.device(), device) => return Ok(Some(shared)),
            other => other.map_or(Ok(()), |other| other.free(gpu))?,
        }
        if self.unshared.as_ref().is_some_and(|unshared| Arc::ptr_eq(unshared, device)) {
            return Ok(None);
        }
        // CUDA can import memory of its own device alone, and need not notice that it is another's.
        let same = gpu.vulkan_uuid().is_none_or(|uuid| uuid == device.found.uuid);
        let shared = same.then(|| Shared::new(gpu, device)).flatten();
        self.unshared = shared.is_none().then(|| device.clone());
        Ok(shared)
    }

    /// None: there was no room for something.
    fn frame_in<G: Gpu>(
        &self,
        session: &mut Session<G>,
        scene: &SceneOnDevice,
        camera: &Camera,
        options: &Options,
        hardware: Option<&mut Hardware>,
    ) -> Result<Option<Frame>, RenderError> {
        let mut clock = Clock::new();
        session.begin()?;
        let geometry = self.geometry_on(session, scene, camera, options, &mut |stage| clock.stage(stage))?;
        let DeviceGeometry { leaves, meshlets } = &geometry;
        let mut all = leaves.geometry(&view(&Lens::new(camera), options), meshlets.meshlets);
        memory(session, &mut all, options, meshlets.vertices)?;
        let input = Input {
            geometry: all,
            leaves: leaves.count,
            staged: options.frame == FrameShape::Staged,
            trims: scene.trims(),
            trimmed: scene.trimmed,
            textured: options.trim == Trim::Texture,
        };
        let Some(drawn) = frame::draw(session, &input, hardware, &mut |stage| clock.stage(stage))? else {
            return Ok(None);
        };
        let filled = drawn.filled.iter().map(|&pixel| Filled { pixel, near: 0, start: None }).collect::<Vec<_>>();
        let GeometryCounts { patches_visible, quads, meshlets_outside, meshlets_inside, meshlets_boundary } =
            geometry.counts(session)?;
        let counts = TrimCounts { meshlets_outside, meshlets_inside, meshlets_boundary, ..TrimCounts::default() };
        let stats = Stats {
            stages: clock.stages_by(&session.times()?),
            patches: self.scene.instances.iter().map(|i| i.patches.len() as u64).sum(),
            patches_visible,
            leaves: session.length(geometry.leaves.count)?,
            meshlets: session.length(geometry.meshlets.meshlets.count)?,
            quads,
            triangles: 2 * quads,
            triangles_hardware: drawn.triangles_hardware,
            bytes_copied: drawn.bytes_copied,
            filled: filled.len() as u64,
            drawn: drawn.near.iter().filter(|&&word| word != 0).count() as u64,
            trim: drawn.trim.plus(counts),
            buffer_bytes: drawn.buffer_bytes,
            asked: session.asks(),
        };
        let targets = Targets::of(drawn.near, drawn.parameters, drawn.color);
        let surface = Surface::Pixels(drawn.shown);
        Ok(Some(Frame { camera: *camera, options: *options, stats, targets, surface, filled }))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cuda::recorded::{Event, Recorded};
    use crate::import;
    use crate::scene::{Scene, ViewSpec, prepare};
    use crate::stages::{FrameShape, STAGES};

    fn scene() -> Scene {
        prepare(&import::load("builtin:trimmed:plate").expect("a model"), &|_, _| {}).expect("a scene")
    }

    /// The ranges that each launch was in; all are closed in the end.
    fn paths(events: &[Event]) -> Vec<(Vec<&'static str>, &str)> {
        let (mut open, mut paths) = (Vec::new(), Vec::new());
        for event in events {
            match event {
                Event::Open(name) => open.push(*name),
                Event::Launch(kernel) => paths.push((open.clone(), kernel.as_str())),
                Event::Record | Event::Run | Event::Transfer(_) => {}
                Event::Broken(what) => panic!("{what} in a recording: {events:?}"),
                Event::Close => assert!(open.pop().is_some(), "more ends than beginnings: {events:?}"),
            }
        }
        assert!(open.is_empty(), "{open:?} never end: {events:?}");
        paths
    }

    fn draw(scene: &Scene, frame: FrameShape, gpu: &mut Recorded) -> Result<Frame, RenderError> {
        let view = ViewSpec { size: [16, 12], ..ViewSpec::default() };
        let options = Options { frame, ..Options::default() };
        Renderer::new(scene).render_on(gpu, &view.camera(&scene.bounds).expect("a camera"), &options)
    }

    #[test]
    fn profilers_see_the_stages_of_a_frame() {
        let scene = scene();
        for frame in [FrameShape::Staged, FrameShape::Fused] {
            let mut gpu = Recorded::default();
            if emulated::missing().is_some() {
                return;
            }
            let found = draw(&scene, frame, &mut gpu).expect("a frame");
            let paths = paths(&gpu.events);
            assert!(paths.iter().all(|(path, _)| path[0] == "frame" && path.len() >= 2), "{paths:?}");
            let mut stages: Vec<&str> = paths.iter().map(|(path, _)| path[1]).collect();
            stages.dedup();
            assert_eq!(stages[..7], STAGES);
            assert_eq!(stages[7..], ["download"]);
            assert_eq!(found.stats.stages.iter().map(|s| s.stage).collect::<Vec<_>>(), STAGES);
            let has = |path: &[&str], kernel: &str| {
                assert!(paths.iter().any(|(p, k)| p == path && *k == kernel), "no {kernel} in {path:?}: {paths:?}");
            };
            has(&["frame", "cull"], "cull_patches");
            has(&["frame", "estimate", "grids"], "estimate_patches_screen");
            has(&["frame", "evaluate", "meshlets", "scan"], "scan_tiles");
            has(&["frame", "trim"], "trim_meshlets");
            has(&["frame", "shade", "pixels"], "shade_pixels");
        }
    }

    /// The first frame asks, the second one makes room by that, the third one has its buffers and is recorded as a whole; so is
    /// each that follows, until one needs more room.
    #[test]
    fn frames_with_all_buffers_are_run_as_a_whole() {
        let scene = scene();
        if emulated::missing().is_some() {
            return;
        }
        let (mut renderer, mut gpu) = (Renderer::new(&scene), Recorded::default());
        let mut draw = |zoom: f64, frame: FrameShape| {
            gpu.events.clear();
            let view = ViewSpec { size: [16, 12], zoom, ..ViewSpec::default() };
            let options = Options { frame, ..Options::default() };
            let camera = view.camera(&scene.bounds).expect("a camera");
            renderer.render_on(&mut gpu, &camera, &options).expect("a frame");
            paths(&gpu.events);
            let count = |event: Event| gpu.events.iter().filter(|e| **e == event).count();
            (count(Event::Record), count(Event::Run))
        };
        for frame in [FrameShape::Fused, FrameShape::Staged] {
            let found = [1.0, 1.0, 1.01, 1.02].map(|zoom| draw(zoom, frame));
            assert_eq!(found, [(0, 0), (0, 0), (1, 1), (1, 1)], "{frame:?}");
        }
    }

    #[test]
    fn ranges_of_a_failed_frame_end() {
        let scene = scene();
        let mut whole = Recorded::default();
        if emulated::missing().is_some() {
            return;
        }
        draw(&scene, FrameShape::Staged, &mut whole).expect("a frame");
        for launches in 0..whole.kernels().count() {
            let mut gpu = Recorded { launches: Some(launches), ..Recorded::default() };
            draw(&scene, FrameShape::Staged, &mut gpu).expect_err("a launch fails");
            assert_eq!(paths(&gpu.events).len(), launches);
        }
    }
}
