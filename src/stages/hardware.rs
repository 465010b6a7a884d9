//! rasterize by hardware: which leaves go there, and what comes back (ETER section 6.2).

use super::cull::{Leaf, Leaves};
use super::error::RenderError;
use super::estimate::Tessellation;
use super::evaluate::{Meshlet, Meshlets, Vertex};
use super::fill::is_tested_alone;
use super::frame::{Renderer, Targets};
use super::lens::Lens;
use super::rasterize::BAND;
use super::{Options, Raster, Route, Trim};
use crate::cuda::hardware::ByHardware;
use crate::cuda::{TrimLists, abi};
use crate::vulkan::{Device, Input, Rasterizer, Validation, VulkanError, threshold};
use glam::Vec2;
use rayon::prelude::*;
use std::sync::Arc;

/// The leaves that hardware draws: whole ones, so that all of a leaf's triangles go one way.
#[derive(Debug)]
pub(super) struct Routes {
    leaves: Taken,
    /// Trims are textures, which software looks up.
    textured: bool,
}

#[derive(Debug)]
enum Taken {
    None,
    All,
    /// By leaf.
    Some(Vec<bool>),
}

/// What the geometry stages hand to the rasterisers.
#[derive(Clone, Copy)]
pub(super) struct Geometries<'a> {
    pub lens: &'a Lens,
    pub options: &'a Options,
    pub leaves: &'a Leaves,
    pub grids: &'a [Tessellation],
    pub meshlets: &'a Meshlets,
}

impl Routes {
    pub fn draws(&self, meshlet: &Meshlet) -> bool {
        let takes = match &self.leaves {
            Taken::None => false,
            Taken::All => true,
            Taken::Some(leaves) => leaves[meshlet.leaf as usize],
        };
        takes && !(meshlet.tested && self.textured)
    }
}

/// A leaf's triangles are at least so large by ETER's bound on their edges, in pixels: its first-derivative rule (section 6.2,
/// equation 2), on the projected net.
pub(super) fn edges_reach(
    leaf: &Leaf,
    grid: &Tessellation,
    net: &[glam::Vec4],
    perspective: bool,
    pixels: f32,
) -> bool {
    let [m, n] = leaf.degree;
    let denominator = |p: glam::Vec4| if perspective { p.z + leaf.depth_origin as f32 * p.w } else { p.w };
    let (mut radius, mut least) = (0.0f32, f32::INFINITY);
    for &p in net {
        let d = denominator(p);
        radius = radius.max(Vec2::new(p.x / d, p.y / d).length());
        least = least.min(d);
    }
    if pixels >= 2.0 * radius {
        return false;
    }
    let reach = (radius - pixels).max(0.0);
    let size = |a: glam::Vec4, b: glam::Vec4| {
        Vec2::new(a.x - b.x, a.y - b.y).length() + reach * (denominator(a) - denominator(b)).abs()
    };
    let (mut along_u, mut along_v) = (0.0f32, 0.0f32);
    for (i, j) in (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let here = net[i * (n + 1) + j];
        if i < m {
            along_u = along_u.max(size(net[(i + 1) * (n + 1) + j], here));
        }
        if j < n {
            along_v = along_v.max(size(net[i * (n + 1) + j + 1], here));
        }
    }
    let edges = along_u * m as f32 / grid.quads[0] as f32 + along_v * n as f32 / grid.quads[1] as f32;
    edges / least >= pixels
}

/// How long a quad's sides may be, in pixels: by the projected net's first differences.
fn quad_side(leaf: &Leaf, grid: &Tessellation, net: &[glam::Vec4], perspective: bool) -> f32 {
    let [m, n] = leaf.degree;
    let at = |i: usize, j: usize| {
        let p = net[i * (n + 1) + j];
        let denominator = if perspective { p.z + leaf.depth_origin as f32 * p.w } else { p.w };
        Vec2::new(p.x, p.y) / denominator
    };
    let (mut along_u, mut along_v) = (0.0f32, 0.0f32);
    for (i, j) in (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        if i < m {
            along_u = along_u.max((at(i + 1, j) - at(i, j)).length());
        }
        if j < n {
            along_v = along_v.max((at(i, j + 1) - at(i, j)).length());
        }
    }
    (along_u * m as f32 / grid.quads[0] as f32).max(along_v * n as f32 / grid.quads[1] as f32)
}

impl Renderer<'_> {
    /// What draws triangles where `Options::raster` asks for hardware, once it has.
    pub fn rasterizer(&self) -> Option<&Rasterizer> {
        self.hardware.as_ref()
    }

    /// Hands it over.
    pub fn take_rasterizer(&mut self) -> Option<Rasterizer> {
        self.hardware.take()
    }

    /// Hardware other than the first that will do.
    pub fn set_rasterizer(&mut self, rasterizer: Rasterizer) {
        (self.hardware, self.large) = (Some(rasterizer), [None; 2]);
    }

    /// Pixels from which on the last frame of `Raster::Hybrid` gave quads to hardware.
    pub fn threshold(&self, options: &Options) -> Option<f64> {
        let known = || options.large.or(self.large[options.route as usize]);
        (options.raster == Raster::Hybrid).then(known).flatten()
    }

    /// Pixels along the longer side of a quad from which on hardware draws it: as asked for, or as has been measured.
    pub(super) fn large(&mut self, options: &Options, device: &Device) -> f64 {
        match options.raster {
            Raster::Hybrid => options.large.unwrap_or_else(|| {
                let (backend, route) = (self.backend, options.route);
                let measured = || threshold::stored(&device.found, backend, route).unwrap_or(threshold::UNMEASURED);
                *self.large[route as usize].get_or_insert_with(measured)
            }),
            _ => 0.0,
        }
    }

    /// What draws by hardware: made when it is first asked for. `uuid`: the GPU that draws the frame, which can share memory;
    /// where Vulkan can't draw with that, any other device will do.
    fn hardware(&mut self, uuid: Option<&str>) -> Result<&mut Rasterizer, RenderError> {
        let open = |uuid| Device::new(Validation::Off, uuid).and_then(Rasterizer::new);
        Ok(match &mut self.hardware {
            Some(rasterizer) => rasterizer,
            none => none.insert(match uuid {
                Some(_) => open(uuid).or_else(|_| open(None))?,
                None => open(None)?,
            }),
        })
    }

    /// The same, to be given back after the frame.
    pub(super) fn take_hardware(&mut self, uuid: Option<&str>) -> Result<Rasterizer, RenderError> {
        self.hardware(uuid)?;
        self.hardware.take().ok_or(RenderError::Vulkan(VulkanError::NoDevice))
    }

    /// The scene's trees, for shaders.
    pub(super) fn trim_lists(&mut self) -> Arc<TrimLists> {
        let scene = self.scene;
        self.trim_lists.get_or_insert_with(|| TrimLists::new(&scene.trims).into()).clone()
    }

    pub(super) fn routes(&mut self, drawn: &Geometries) -> Result<Routes, RenderError> {
        let Geometries { lens, options, leaves, grids, .. } = *drawn;
        let textured = options.trim == Trim::Texture;
        match options.raster {
            Raster::Auto | Raster::Software => return Ok(Routes { leaves: Taken::None, textured }),
            Raster::Hardware => return Ok(Routes { leaves: Taken::All, textured }),
            Raster::Hybrid => {}
        }
        let device = self.hardware(None)?.device().clone();
        let from = self.large(options, &device) as f32;
        let large = |(leaf, grid): (&Leaf, &Tessellation)| {
            let net = &leaves.nets[leaf.net as usize..leaf.net as usize + leaf.points()];
            match options.route {
                _ if from <= 0.0 => true,
                Route::Net => quad_side(leaf, grid, net, lens.perspective) >= from,
                Route::Eter => edges_reach(leaf, grid, net, lens.perspective, from),
            }
        };
        let leaves = Taken::Some(leaves.leaves.par_iter().zip(grids).map(large).collect());
        Ok(Routes { leaves, textured })
    }

    /// Draws what is routed to the hardware into buffers that have been begun; returns what else came of it.
    pub(super) fn rasterize_by_hardware(
        &mut self,
        drawn: &Geometries,
        routes: &Routes,
        targets: &mut Targets,
    ) -> Result<ByHardware, RenderError> {
        let Geometries { lens, options, leaves, grids, meshlets } = *drawn;
        if matches!(routes.leaves, Taken::None) {
            return Ok(ByHardware::default());
        }
        let drawn = meshlets.meshlets.iter().enumerate().filter(|(_, m)| routes.draws(m));
        let numbers: Vec<u32> = drawn.map(|(k, _)| k as u32).collect();
        if numbers.is_empty() {
            return Ok(ByHardware::default());
        }
        let tested = numbers.iter().any(|&k| meshlets.meshlets[k as usize].tested);
        let trims = tested.then(|| self.trim_lists());
        let staged = self.staged_of(lens, options, leaves, grids, meshlets);
        let vertex = |v: &Vertex| abi::Vertex { x: v.x, y: v.y, depth: v.depth, weight: v.weight };
        let vertices: Vec<abi::Vertex> = meshlets.vertices.par_iter().map(vertex).collect();
        let input = Input {
            size: lens.size,
            fill: options.fill,
            patches: &staged.patches,
            leaves: &staged.leaves,
            meshlets: &staged.meshlets,
            vertices: &vertices,
            numbers: &numbers,
            trims: trims.as_ref(),
            alone: is_tested_alone(options),
        };
        let drawn = self.hardware(None)?.draw(&input).map(|drawn| {
            merge(lens.size[0] as usize * BAND, drawn.near, drawn.spare, targets);
            (drawn.listed.to_vec(), drawn.copied)
        });
        if drawn.as_ref().is_err_and(VulkanError::is_final) {
            // The next frame opens the device anew.
            self.hardware = None;
        }
        let triangles = |&k: &u32| 2 * meshlets.meshlets[k as usize].quads.map(u64::from).iter().product::<u64>();
        let (listed, copied) = drawn?;
        Ok(ByHardware { triangles: numbers.iter().map(triangles).sum(), copied, listed })
    }
}

/// The larger word stays in both buffers. `band`: pixels of one.
fn merge(band: usize, near: &[u64], spare: &[u64], targets: &mut Targets) {
    let bands = targets.near.par_chunks_mut(band).zip(targets.spare.par_chunks_mut(band));
    let bands = bands.zip(targets.touched.par_iter_mut());
    bands.zip(near.par_chunks(band).zip(spare.par_chunks(band))).for_each(|(((n, s), touched), (near, spare))| {
        n.iter_mut().zip(near).for_each(|(word, &other)| *word = (*word).max(other));
        for (k, (word, &other)) in s.iter_mut().zip(spare).enumerate().filter(|(_, (_, other))| **other != 0) {
            if *word == 0 {
                touched.push(k as u32);
            }
            *word = (*word).max(other);
        }
    });
}
