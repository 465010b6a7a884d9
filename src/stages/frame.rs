//! The frame: its buffers, its statistics, and the order of the stages.

use super::basis::BasisTables;
use super::cull::{Culler, Leaf, Leaves};
use super::device::{Engine, Kept};
use super::error::RenderError;
use super::estimate::{Tessellation, estimate};
use super::evaluate::{Meshlets, Vertex, View, evaluate};
use super::fill::{Filled, fill};
use super::hardware::Geometries;
use super::interpolate::interpolate;
use super::lens::Lens;
use super::rasterize::{BAND, rasterize};
use super::shade::{Shader, shade};
use super::slefe;
use super::stats::{Clock, Stats};
use super::stroke::{Pen, sags};
use super::topology::{MAX_MESHLETS, depth_of, is_edge, meshlet_of};
use super::trim::trim;
use super::trim_cut::gaps;
use super::trim_texture::textures;
use super::{Bound, FrameShape, Options, Precision, Trim};
use crate::cuda::selection::{Clocks, Selection};
use crate::cuda::shared::Shared;
use crate::cuda::{self, TrimLists, abi, evaluate::Staged, scene::SceneOnDevice};
use crate::scene::{Camera, PatchTrim, Scene};
use crate::vulkan::{self, Rasterizer};
use glam::Vec4;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// Patches one task culls and estimates.
const CHUNK: usize = 128;

/// What the frame stores for one drawn pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Index into `Scene::patches`.
    pub patch: u32,
    /// (u, v) in the Bézier patch's unit square as interpolated on the triangle (before refinement).
    pub interpolated: [f64; 2],
    /// (u, v) in the Bézier patch's unit square as stored (after refinement).
    pub stored: [f64; 2],
    /// Stored depth (larger is nearer).
    pub depth: f32,
    /// The spare buffer decided this pixel.
    pub filled: bool,
}

/// Image buffers, kept from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Targets {
    /// N, centre-covered fragments; after fill the visibility buffer. 0: background.
    pub near: Vec<u64>,
    /// S, what may close a crack.
    pub spare: Vec<u64>,
    /// Pixels that `spare` has, by band.
    pub touched: Vec<Vec<u32>>,
    /// Leaf parameters; meaningless where `near` is 0.
    pub parameters: Vec<[f32; 2]>,
    /// Linear RGB; meaningless where `near` is 0.
    pub color: Vec<[f32; 3]>,
}

/// A finished frame.
#[derive(Debug)]
pub struct Frame {
    pub camera: Camera,
    pub options: Options,
    pub stats: Stats,
    pub(super) targets: Targets,
    pub(super) surface: Surface,
    pub(super) filled: Vec<Filled>,
}

/// What tells which point of the model a pixel shows.
#[derive(Debug)]
pub(super) enum Surface {
    /// The grids that were drawn.
    Grids { leaves: Vec<Leaf>, grids: Vec<Tessellation>, meshlets: Meshlets },
    /// By pixel, as a device left it.
    Pixels(Vec<abi::Shown>),
}

/// Draws a scene; keeps its buffers from frame to frame.
#[derive(Debug)]
pub struct Renderer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) engine: Engine,
    /// Its name.
    pub(super) backend: &'static str,
    /// What the engine's device has of the scene.
    pub(super) resident: Option<SceneOnDevice>,
    clocks: Clocks,
    pub(super) kept: Option<Kept>,
    tables: BasisTables,
    spare_targets: Option<Targets>,
    /// Made when a frame first asks for it.
    pub(super) hardware: Option<Rasterizer>,
    /// Pixels from which on quads are its, by `Route`, once that has been looked up.
    pub(super) large: [Option<f64>; 2],
    /// What the engine's device shares with it.
    pub(super) shared: Option<Shared>,
    /// A device that was found to share nothing with it.
    pub(super) unshared: Option<Arc<vulkan::Device>>,
    /// The scene's, where hardware has drawn trimmed faces.
    pub(super) trim_lists: Option<Arc<TrimLists>>,
}

/// What the geometry stages make of all patches.
#[derive(Default)]
pub(super) struct Geometry {
    pub leaves: Leaves,
    pub grids: Vec<Tessellation>,
}

impl<'a> Renderer<'a> {
    /// By the CPU.
    pub fn new(scene: &'a Scene) -> Self {
        Self::with(scene, Engine::Cpu)
    }

    pub fn with(scene: &'a Scene, engine: Engine) -> Self {
        let clocks = engine.clocks();
        Self {
            scene,
            backend: engine.name(),
            engine,
            resident: None,
            clocks,
            kept: None,
            tables: BasisTables::new(),
            spare_targets: None,
            hardware: None,
            large: [None; 2],
            shared: None,
            unshared: None,
            trim_lists: None,
        }
    }

    /// By what kernels' patches get their arithmetic.
    pub(super) fn selection(&self, options: &Options) -> Selection {
        let large_blocks = options.frame == FrameShape::Fused;
        Selection { precision: options.precision, clocks: self.clocks, large_blocks }
    }

    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Draws one frame: cull, estimate, evaluate, rasterize, trim, fill, shade.
    pub fn render(&mut self, camera: &Camera, options: &Options) -> Result<Frame, RenderError> {
        self.check(options)?;
        let mut engine = std::mem::take(&mut self.engine);
        let frame = match &mut engine {
            Engine::Cpu => self.render_here(camera, options),
            Engine::Emulated(device) => self.render_on(&mut **device, camera, options),
            Engine::Cuda(stream) => self.render_on(&mut **stream, camera, options),
        };
        self.engine = engine;
        frame
    }

    fn render_here(&mut self, camera: &Camera, options: &Options) -> Result<Frame, RenderError> {
        let options = &match options.precision {
            Precision::F32 | Precision::Auto => Options { precision: Precision::F32, ..*options },
            _ => return Err(RenderError::NoTensorCores),
        };
        let lens = Lens::new(camera);
        let mut clock = Clock::new();
        let culled = self.cull(&lens, options)?;
        clock.stage("cull");
        let Geometry { leaves, grids } = self.estimate(&lens, options, culled)?;
        clock.stage("estimate");
        let meshlets = self.evaluate(&lens, options, &leaves, &grids)?;
        clock.stage("evaluate");
        let mut targets = self.take_targets(camera.size);
        let pen = |(leaf, grid)| self.pen(&lens, options, leaf, grid, &leaves.nets);
        let pens: Vec<Pen> = leaves.leaves.par_iter().zip(&grids).map(pen).collect();
        let drawn = Geometries { lens: &lens, options, leaves: &leaves, grids: &grids, meshlets: &meshlets };
        let routes = self.routes(&drawn)?;
        let software = |k: &u32| !routes.draws(&meshlets.meshlets[*k as usize]);
        let numbers = (0..meshlets.meshlets.len() as u32).filter(software);
        rasterize(&meshlets, numbers, &pens, options, camera.size, &mut targets);
        let hardware = self.rasterize_by_hardware(&drawn, &routes, &mut targets)?;
        clock.stage("rasterize");
        let Leaves { leaves, nets, patches_visible } = leaves;
        let mut shader = Shader {
            scene: self.scene,
            lens: &lens,
            options,
            meshlets: &meshlets,
            leaves: &leaves,
            nets: &nets,
            grids: &grids,
            textures: Vec::new(),
        };
        shader.textures = textures(&shader);
        let trim = meshlets.trim.plus(trim(&shader, &pens, &routes, &hardware.listed, &mut targets));
        clock.stage("trim");
        let mut filled = fill(&meshlets, options, camera.size, &mut targets);
        clock.stage("fill");
        shade(&shader, &mut targets, &mut filled);
        clock.stage("shade");
        let stats = Stats {
            stages: clock.stages(),
            patches: self.scene.instances.iter().map(|i| i.patches.len() as u64).sum(),
            patches_visible,
            leaves: leaves.len() as u64,
            meshlets: meshlets.meshlets.len() as u64,
            quads: meshlets.quads,
            triangles: 2 * meshlets.quads,
            triangles_hardware: hardware.triangles,
            bytes_copied: hardware.copied,
            filled: filled.len() as u64,
            drawn: targets.near.par_iter().filter(|&&word| word != 0).count() as u64,
            trim,
            buffer_bytes: targets.bytes()
                + trim.texture_bytes
                + (meshlets.bytes() + size_of_val(&nets[..]) + size_of_val(&leaves[..])) as u64,
            asked: false,
        };
        let surface = Surface::Grids { leaves, grids, meshlets };
        Ok(Frame { camera: *camera, options: *options, stats, targets, surface, filled })
    }

    /// What the kernels of evaluate are given in a frame, and the vertices that the CPU makes of it.
    pub fn staged(&self, camera: &Camera, options: &Options) -> Result<(Staged, Vec<abi::Vertex>), RenderError> {
        self.check(options)?;
        let lens = Lens::new(camera);
        let Geometry { leaves, grids } = self.estimate(&lens, options, self.cull(&lens, options)?)?;
        let meshlets = self.evaluate(&lens, options, &leaves, &grids)?;
        let staged = self.staged_of(&lens, options, &leaves, &grids, &meshlets);
        let vertex = |v: &Vertex| abi::Vertex { x: v.x, y: v.y, depth: v.depth, weight: v.weight };
        Ok((staged, meshlets.vertices.iter().map(vertex).collect()))
    }

    pub(super) fn staged_of(
        &self,
        lens: &Lens,
        options: &Options,
        leaves: &Leaves,
        grids: &[Tessellation],
        meshlets: &Meshlets,
    ) -> Staged {
        let mut staged = Staged::new(lens, options, &self.tables, leaves, grids, meshlets);
        let selection = self.selection(options);
        let described = |(leaf, grid)| {
            let pen = self.pen(lens, options, leaf, grid, &leaves.nets);
            let arithmetic = selection.of_grid(leaf.arithmetic, grid.quads);
            cuda::leaves::leaf(self.scene, lens, options, leaf, grid, &pen, arithmetic)
        };
        staged.leaves = leaves.leaves.par_iter().zip(grids).map(described).collect();
        staged
    }

    /// Takes a frame's buffers back for the next one.
    pub fn recycle(&mut self, frame: Frame) {
        self.spare_targets = Some(frame.targets);
    }

    pub(super) fn check(&self, options: &Options) -> Result<(), RenderError> {
        // Single points are no larger than their rounding; they are drawn, if nowhere.
        let size = (self.scene.bounds.high - self.scene.bounds.low).max_element();
        if size > 0.0 && !(1e-30..=1e30).contains(&size) {
            return Err(RenderError::ModelSize { size });
        }
        if options.bound != Bound::Slefe {
            return Ok(());
        }
        let unsupported = self.scene.patches.iter().find_map(|p| {
            let degree = p.degree[0].max(p.degree[1]);
            let what = if p.rational {
                "rational".to_string()
            } else if degree > slefe::MAX_DEGREE {
                format!("of degree {degree}")
            } else {
                return None;
            };
            Some(RenderError::SlefeUnsupported { face: self.scene.faces[p.face as usize].id, what })
        });
        unsupported.map_or(Ok(()), Err)
    }

    /// The drawn patches as (instance, patch), in tasks.
    fn tasks(&self) -> Vec<(u32, std::ops::Range<usize>)> {
        let mut tasks = Vec::new();
        for (k, instance) in self.scene.instances.iter().enumerate() {
            for start in instance.patches.clone().step_by(CHUNK) {
                tasks.push((k as u32, start..(start + CHUNK).min(instance.patches.end)));
            }
        }
        tasks
    }

    pub(super) fn cull(&self, lens: &Lens, options: &Options) -> Result<Vec<Leaves>, RenderError> {
        let selection = &self.selection(options);
        let cull_one = |(instance, patches): (u32, std::ops::Range<usize>)| {
            let mut culler = Culler::new(self.scene, lens, options, selection);
            let mut leaves = Leaves::default();
            for patch in patches {
                culler.patch(instance, patch as u32, &mut leaves)?;
            }
            Ok(leaves)
        };
        self.tasks().into_par_iter().map(cull_one).collect()
    }

    pub(super) fn estimate(
        &self,
        lens: &Lens,
        options: &Options,
        culled: Vec<Leaves>,
    ) -> Result<Geometry, RenderError> {
        let vertices = AtomicU64::new(0);
        let selection = &self.selection(options);
        let estimated: Vec<(Leaves, Vec<Tessellation>)> = (culled.into_par_iter())
            .map(|leaves| estimate(&mut Culler::new(self.scene, lens, options, selection), leaves, &vertices))
            .collect::<Result<_, _>>()?;
        let mut all = Geometry::default();
        for (leaves, grids) in estimated {
            let offset = all.leaves.nets.len() as u32;
            all.leaves.leaves.extend(leaves.leaves.into_iter().map(|leaf| Leaf { net: leaf.net + offset, ..leaf }));
            all.leaves.nets.extend(leaves.nets);
            all.leaves.patches_visible += leaves.patches_visible;
            all.grids.extend(grids);
        }
        Ok(all)
    }

    pub(super) fn evaluate(
        &self,
        lens: &Lens,
        options: &Options,
        leaves: &Leaves,
        grids: &[Tessellation],
    ) -> Result<Meshlets, RenderError> {
        let needed: u64 = grids.iter().map(Tessellation::meshlets).sum();
        if needed > MAX_MESHLETS {
            return Err(RenderError::TooManyMeshlets { needed, limit: MAX_MESHLETS });
        }
        let view = View { scene: self.scene, lens, options };
        let chunks: Vec<Meshlets> = (leaves.leaves.par_chunks(CHUNK).zip(grids.par_chunks(CHUNK)).enumerate())
            .map(|(k, (chunk, grids))| evaluate(&view, &self.tables, chunk, &leaves.nets, k * CHUNK, grids))
            .collect();
        let mut all = Meshlets::default();
        for chunk in chunks {
            all.append(chunk);
        }
        Ok(all)
    }

    fn pen(&self, lens: &Lens, options: &Options, leaf: &Leaf, grid: &Tessellation, nets: &[Vec4]) -> Pen {
        let PatchTrim { tree, rim, .. } = self.scene.patches[leaf.patch as usize].trim;
        let ends = options.trim != Trim::Off && (tree.is_some() || rim);
        let gap = ends.then(|| gaps(self.scene, lens, leaf)[1]);
        let net = &nets[leaf.net as usize..leaf.net as usize + leaf.points()];
        Pen::new(leaf, grid, options, gap, sags(leaf, net, lens.perspective))
    }

    fn take_targets(&mut self, size: [u32; 2]) -> Targets {
        let pixels = size[0] as usize * size[1] as usize;
        let mut targets = self.spare_targets.take().unwrap_or_default();
        let bands = (size[1] as usize).div_ceil(BAND);
        if targets.near.len() != pixels || targets.touched.len() != bands {
            targets = Targets {
                near: vec![0; pixels],
                spare: vec![0; pixels],
                touched: vec![Vec::new(); bands],
                parameters: vec![[0.0; 2]; pixels],
                color: vec![[0.0; 3]; pixels],
            };
        }
        targets
    }
}

impl Targets {
    /// Of a frame that a device drew.
    pub fn of(near: Vec<u64>, parameters: Vec<[f32; 2]>, color: Vec<[f32; 3]>) -> Self {
        Self { near, parameters, color, ..Self::default() }
    }

    fn bytes(&self) -> u64 {
        let touched: usize = self.touched.iter().map(|t| t.capacity() * size_of::<u32>()).sum();
        (touched + self.near.len() * (2 * size_of::<u64>() + size_of::<[f32; 2]>() + size_of::<[f32; 3]>())) as u64
    }
}

impl Frame {
    pub fn size(&self) -> [u32; 2] {
        self.camera.size
    }

    /// What pixel (x, y) shows; `None` where it is background.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        let index = y as usize * self.camera.size[0] as usize + x as usize;
        let word = self.targets.near[index];
        if word == 0 {
            return None;
        }
        let (depth, filled) = (depth_of(word), self.is_filled(index, word));
        Some(match &self.surface {
            Surface::Grids { leaves, grids, meshlets } => {
                let number = meshlets.meshlets[meshlet_of(word) as usize].leaf as usize;
                let leaf = &leaves[number];
                let interpolated = interpolate(meshlets, grids[number].quads, word, x, y);
                Pixel {
                    instance: leaf.instance,
                    patch: leaf.patch,
                    interpolated: leaf.to_patch(interpolated.map(f64::from)),
                    stored: leaf.to_patch(self.targets.parameters[index].map(f64::from)),
                    depth,
                    filled,
                }
            }
            Surface::Pixels(pixels) => {
                let abi::Shown { interpolated, stored, instance, patch } = pixels[index];
                Pixel { instance, patch, interpolated, stored, depth, filled }
            }
        })
    }

    /// Linear RGBA of pixel (x, y); transparent black where it is background.
    pub fn color(&self, x: u32, y: u32) -> [f32; 4] {
        let index = y as usize * self.camera.size[0] as usize + x as usize;
        if self.targets.near[index] == 0 {
            return [0.0; 4];
        }
        let [r, g, b] = self.targets.color[index];
        [r, g, b, 1.0]
    }

    /// The visibility word of pixel (x, y): depth bits << 32 | meshlet << 7 | index.
    pub fn word(&self, x: u32, y: u32) -> u64 {
        self.targets.near[y as usize * self.camera.size[0] as usize + x as usize]
    }

    fn is_filled(&self, index: usize, word: u64) -> bool {
        is_edge(word) || self.filled.binary_search_by_key(&(index as u32), |f| f.pixel).is_ok()
    }
}
