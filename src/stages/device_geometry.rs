//! cull, estimate and the list of meshlets by a device's kernels: the CPU's own words.

use super::Options;
use super::cull::{Culler, Leaves};
use super::device::Engine;
use super::error::RenderError;
use super::estimate::estimate;
use super::frame::Renderer;
use super::lens::Lens;
use super::topology::MAX_MESHLETS;
use crate::cuda::cull::{Seen, rules};
use crate::cuda::estimate::Stopped;
use crate::cuda::evaluate::{Staged, vertices, view};
use crate::cuda::scene::SceneOnDevice;
use crate::cuda::session::Session;
use crate::cuda::{Gpu, GpuError, abi, cull, estimate as grids, meshlets};
use crate::scene::Camera;
use std::sync::atomic::AtomicU64;

/// What the geometry stages counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometryCounts {
    pub patches_visible: u64,
    pub quads: u64,
    /// Of patches that loops cut: as in `TrimCounts`.
    pub meshlets_outside: u64,
    pub meshlets_inside: u64,
    pub meshlets_boundary: u64,
}

/// What the geometry stages left on a device.
pub(crate) struct DeviceGeometry {
    pub leaves: grids::Leaves,
    pub meshlets: meshlets::Meshlets,
}

impl Renderer<'_> {
    /// Cull, estimate and the list of meshlets on a device; `ended` is told of the first two's ends.
    pub(crate) fn geometry_on<G: Gpu>(
        &self,
        session: &mut Session<G>,
        scene: &SceneOnDevice,
        camera: &Camera,
        options: &Options,
        ended: &mut dyn FnMut(&'static str),
    ) -> Result<DeviceGeometry, RenderError> {
        let lens = Lens::new(camera);
        let whole = lens.shows_whole(self.scene.bounds.center(), self.scene.bounds.radius());
        let seen =
            Seen { scene, view: view(&lens, options), rules: rules(&lens, options, &self.selection(options), whole) };
        let visible = cull::cull(session, &seen)?;
        session.finish()?;
        ended("cull");
        let why = |stopped| self.why(&lens, options, stopped);
        let leaves = grids::estimate(session, &seen, visible).map_err(why)?;
        session.finish()?;
        ended("estimate");
        let meshlets = session.group("meshlets", |session| meshlets::meshlets(session, &seen, &leaves)).map_err(why)?;
        Ok(DeviceGeometry { leaves, meshlets })
    }

    /// What `Renderer::staged` makes, by a device's kernels.
    pub fn staged_on<G: Gpu>(
        &self,
        gpu: &mut G,
        camera: &Camera,
        options: &Options,
    ) -> Result<(Staged, GeometryCounts), RenderError> {
        self.check(options)?;
        let scene = SceneOnDevice::upload(gpu, self.scene)?;
        let mut session = Session::new(gpu);
        session.begin()?;
        let geometry = self.geometry_on(&mut session, &scene, camera, options, &mut |_| {});
        let staged = geometry.and_then(|geometry| {
            let staged = download(&mut session, &geometry)?;
            Ok((Staged { view: view(&Lens::new(camera), options), ..staged }, geometry.counts(&mut session)?))
        });
        session.free()?;
        scene.free(gpu)?;
        staged
    }

    /// How far the vertices that a device draws are from those in f32: the largest part of what bounds allow
    /// ([`Staged::off`]). None on the CPU.
    pub fn vertices_off(&mut self, camera: &Camera, options: &Options) -> Result<Option<f64>, RenderError> {
        let mut engine = std::mem::take(&mut self.engine);
        let off = match &mut engine {
            Engine::Cpu => Ok(None),
            Engine::Emulated(device) => self.vertices_off_on(&mut **device, camera, options).map(Some),
            Engine::Cuda(stream) => self.vertices_off_on(&mut **stream, camera, options).map(Some),
        };
        self.engine = engine;
        off
    }

    fn vertices_off_on<G: Gpu>(&self, gpu: &mut G, camera: &Camera, options: &Options) -> Result<f64, RenderError> {
        let (staged, _) = self.staged_on(gpu, camera, options)?;
        let found = vertices(gpu, &staged)?;
        Ok(staged.off(&found, &vertices(gpu, &staged.single())?))
    }

    /// The CPU's own words for what stopped a device.
    fn why(&self, lens: &Lens, options: &Options, stopped: Stopped) -> RenderError {
        match stopped {
            Stopped::Gpu(error) => error.into(),
            Stopped::Vertices => RenderError::TooManyVertices { limit: super::estimate::MAX_VERTICES },
            Stopped::Meshlets { needed } => RenderError::TooManyMeshlets { needed, limit: MAX_MESHLETS },
            Stopped::Item { item, error } => self.why_item(lens, options, item, error),
        }
    }

    /// The patch again, by the CPU: its error says all.
    fn why_item(&self, lens: &Lens, options: &Options, item: u32, error: u32) -> RenderError {
        let mut number = item as usize;
        let mut instances = self.scene.instances.iter().enumerate();
        let found = instances.find_map(|(k, instance)| {
            let patch = instance.patches.clone().nth(number);
            number = number.saturating_sub(instance.patches.len());
            patch.map(|patch| (k as u32, patch as u32))
        });
        let (instance, patch) = found.unwrap_or_default();
        let selection = self.selection(options);
        let mut culler = Culler::new(self.scene, lens, options, &selection);
        let mut leaves = Leaves::default();
        let culled = culler.patch(instance, patch, &mut leaves);
        let estimated = culled.and_then(|()| estimate(&mut culler, leaves, &AtomicU64::new(0)));
        let face = self.scene.faces[self.scene.patches[patch as usize].face as usize].id;
        estimated.err().unwrap_or(match error {
            abi::ERROR_TOO_CLOSE => RenderError::TooClose { face, patch },
            _ => RenderError::TooManyLeaves { face, patch, limit: super::cull::MAX_LEAVES },
        })
    }
}

impl DeviceGeometry {
    /// Waits for them, unless the frame has ended.
    pub fn counts<G: Gpu>(&self, session: &mut Session<G>) -> Result<GeometryCounts, GpuError> {
        let meshlets::Counted { quads, inside, boundary, outside } = self.meshlets.counted(session)?;
        Ok(GeometryCounts {
            patches_visible: self.leaves.patches_visible(session)?,
            quads,
            meshlets_outside: outside,
            meshlets_inside: inside,
            meshlets_boundary: boundary,
        })
    }
}

fn download<G: Gpu>(session: &mut Session<G>, geometry: &DeviceGeometry) -> Result<Staged, GpuError> {
    let DeviceGeometry { leaves, meshlets } = geometry;
    Ok(Staged {
        patches: session.download(&leaves.patches)?,
        leaves: session.download(&leaves.leaves)?,
        meshlets: session.download(&meshlets.meshlets.buffer)?,
        nets: session.download(&leaves.nets)?,
        basis: session.download(&leaves.basis)?,
        vertices: session.length(meshlets.vertices)? as usize,
        ..Staged::default()
    })
}
