//! evaluate, host side: a frame's patches and meshlets as `kernels/abi.h` describes them.

use super::count::{Count, List};
use super::gpu::pods;
use super::precision::{Arithmetic, Hull, Kernel, LARGEST_TENSOR_DEGREE};
use super::scan::scan;
use super::session::{Geometry, Session};
use super::shared::Role;
use super::{Argument, Buffer, Gpu, GpuError, Pointer, Shape, abi};
use crate::stages::cull::Leaves;
use crate::stages::estimate::Tessellation;
use crate::stages::evaluate::Meshlets;
use crate::stages::lens::Lens;
use crate::stages::{Fill, FrameShape, Interpolation, Options, Precision, Trim, basis::BasisTables};
use std::collections::BTreeMap;

/// Meshlets a block of the kernels evaluates, a warp each.
pub const WARPS: u32 = 4;

/// What the kernels of `kernels/evaluate.cu` are given.
#[derive(Clone, Debug, Default)]
pub struct Staged {
    pub view: abi::View,
    pub patches: Vec<abi::Patch>,
    /// The same patches, for the stages that draw them.
    pub leaves: Vec<abi::Leaf>,
    /// In the order of their numbers.
    pub meshlets: Vec<abi::Meshlet>,
    pub nets: Vec<abi::Point>,
    /// Bernstein values, a table for each degree and grid size that occurs.
    pub basis: Vec<f32>,
    /// Vertices of all meshlets.
    pub vertices: usize,
}

impl Staged {
    /// Of the CPU's own cull and estimate. Degrees fit a byte: `geometry::MAX_DEGREE`.
    pub(crate) fn new(
        lens: &Lens,
        options: &Options,
        tables: &BasisTables,
        leaves: &Leaves,
        grids: &[Tessellation],
        meshlets: &Meshlets,
    ) -> Self {
        let mut staged = Self { view: view(lens, options), vertices: meshlets.vertices.len(), ..Self::default() };
        // In order of degree and size: no thread of a device needs to know who came first.
        let mut places: BTreeMap<(usize, u32), u32> = BTreeMap::new();
        for (leaf, grid) in leaves.leaves.iter().zip(grids) {
            places.extend([0, 1].map(|k| ((leaf.degree[k], grid.quads[k]), 0)));
        }
        for (&(degree, quads), start) in &mut places {
            *start = staged.basis.len() as u32;
            tables.with(degree, quads, |table| staged.basis.extend_from_slice(table));
        }
        for (leaf, grid) in leaves.leaves.iter().zip(grids) {
            let basis = [0, 1].map(|k| places[&(leaf.degree[k], grid.quads[k])]);
            staged.patches.push(abi::Patch {
                net: leaf.net,
                basis,
                quads: grid.quads.map(|n| n as u16),
                degree: leaf.degree.map(|d| d as u8),
                diagonal: grid.diagonal,
                hidden: leaf.hidden,
                base: lens.base(leaf.center),
                depth_origin: leaf.depth_origin as f32,
                depth_offset: lens.depth_offset(leaf.depth_origin),
                rounding: leaf.rounding as f32,
                instance: leaf.instance,
                source: leaf.patch,
            });
        }
        staged.nets = leaves.nets.iter().map(|p| abi::Point { x: p.x, y: p.y, z: p.z, w: p.w }).collect();
        staged.meshlets = (meshlets.meshlets.iter())
            .map(|m| abi::Meshlet {
                patch: m.leaf,
                vertices: m.vertices,
                first: m.first,
                quads: m.quads,
                outer: m.outer,
                tested: u8::from(m.tested),
            })
            .collect();
        staged
    }

    /// What a patch is evaluated in.
    pub fn arithmetic(&self, patch: usize) -> Arithmetic {
        self.leaves.get(patch).and_then(|leaf| Arithmetic::numbered(leaf.arithmetic)).unwrap_or_default()
    }

    /// The same in f32.
    pub fn single(&self) -> Self {
        let mut single = self.clone();
        single.leaves.iter_mut().for_each(|leaf| leaf.arithmetic = Arithmetic::F32 as u16);
        single
    }

    /// How far vertices are from those in f32, in place and in depth: the largest part of what the bounds of both arithmetics,
    /// and snapping, allow.
    pub fn off(&self, found: &[abi::Vertex], single: &[abi::Vertex]) -> f64 {
        let mut most = 0.0_f64;
        for meshlet in &self.meshlets {
            let number = meshlet.patch as usize;
            let patch = &self.patches[number];
            let points: usize = patch.degree.iter().map(|&d| usize::from(d) + 1).product();
            let hull = Hull::new(&self.view, patch, &self.nets[patch.net as usize..][..points]);
            let bounds = [self.arithmetic(number), Arithmetic::F32].map(|a| a.bound(&hull));
            let place = f64::from(abi::SUBPIXELS) * bounds.iter().map(|b| b.place).sum::<f64>() + 1.0;
            let depth = bounds.iter().map(|b| b.depth).sum::<f64>();
            let vertices = meshlet.quads.iter().map(|&n| usize::from(n) + 1).product::<usize>();
            let all = meshlet.vertices as usize..meshlet.vertices as usize + vertices;
            for (a, b) in found[all.clone()].iter().zip(&single[all]) {
                let apart = f64::from((a.x - b.x).abs().max((a.y - b.y).abs()));
                let whole = if self.view.perspective != 0 { f64::from(a.depth.max(b.depth)) } else { 1.0 };
                let deeper = f64::from((a.depth - b.depth).abs());
                most = most.max(apart / place).max(deeper / (depth * whole));
            }
        }
        most
    }

    /// The kernels that evaluate all meshlets, each with its own, by degree and arithmetic of their patches.
    pub fn bins(&self) -> Vec<(String, Vec<abi::Meshlet>)> {
        let mut bins: BTreeMap<Kernel, Vec<abi::Meshlet>> = BTreeMap::new();
        for meshlet in &self.meshlets {
            let patch = meshlet.patch as usize;
            let kernel = self.arithmetic(patch).kernel(self.patches[patch].degree);
            bins.entry(kernel).or_default().push(*meshlet);
        }
        bins.into_iter().map(|(kernel, meshlets)| (kernel.to_string(), meshlets)).collect()
    }
}

/// Memory for the vertices that a frame keeps: in the staged shape all, in the fused one what tensor cores make. Meshlets without
/// any are told so.
pub(crate) fn memory<G: Gpu>(
    session: &mut Session<G>,
    geometry: &mut Geometry,
    options: &Options,
    all: Count,
) -> Result<(), GpuError> {
    if options.frame == FrameShape::Staged {
        geometry.vertices = Some(session.allocate_as(Role::Vertices, all.room())?);
        return Ok(());
    }
    if options.precision == Precision::F32 {
        return Ok(());
    }
    let count = geometry.meshlets.count;
    let counts = session.allocate::<u32>(count.room())?;
    let (leaves, meshlets) = (geometry.leaves.pointer(), geometry.meshlets.pointer());
    session.for_all("evaluate_kept", count, &[&count, &leaves, &meshlets, &counts.pointer()])?;
    let (firsts, kept) = scan(session, &counts, count)?;
    let places: [&dyn Argument; 4] = [&count, &counts.pointer(), &firsts.pointer(), &meshlets];
    session.for_all("evaluate_places", count, &places)?;
    let kept = session.count_of(kept, "vertices")?;
    geometry.meshlets.count = session.both(count, kept)?;
    geometry.vertices = Some(session.allocate(kept.room())?);
    Ok(())
}

/// `bins::Places` of kernels/bins.cu.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
struct Places {
    first: [u32; BINS],
    room: [u32; BINS],
}

pods!(Places);

/// Kernels of [`Kernel::all`]: f32 for any degrees and for each that tensor cores do, and one for every other arithmetic.
const BINS: usize = LARGEST_TENSOR_DEGREE as usize + abi::ARITHMETICS as usize;

/// The vertices of all meshlets that are kept, each patch in its own arithmetic.
pub(crate) fn evaluate<G: Gpu>(
    session: &mut Session<G>,
    geometry: &Geometry,
    vertices: &Buffer<abi::Vertex>,
) -> Result<(), GpuError> {
    let Geometry { view, patches, leaves, nets, basis, meshlets, .. } = geometry;
    let sort = |session: &mut Session<G>, places: Places, out: Pointer<abi::Meshlet>| {
        let counted = session.counters(BINS)?;
        let (patches, leaves, from) = (patches.pointer(), leaves.pointer(), meshlets.pointer());
        let arguments: [&dyn Argument; 7] = [&patches, &leaves, &from, &meshlets.count, &counted, &places, &out];
        session.for_all("evaluate_bins", meshlets.count, &arguments)?;
        Ok::<_, GpuError>(counted)
    };
    // Room by an earlier frame needs no count before meshlets are sorted.
    let counted = if session.asks() { sort(session, Places::default(), Pointer::NULL)? } else { Pointer::NULL };
    let mut places = Places::default();
    let mut total = 0;
    for bin in 0..BINS {
        let counted = Pointer { ..counted }.offset(bin);
        let room = session.number(meshlets.room() as u64, |session| session.value(counted))? as u32;
        (places.first[bin], places.room[bin]) = (total, room);
        total += room;
    }
    let sorted = session.allocate::<abi::Meshlet>(total as usize)?;
    let counted = sort(session, places, sorted.pointer())?;
    for (bin, kernel) in Kernel::all().enumerate().filter(|(bin, _)| places.room[*bin] > 0) {
        let (first, room) = (places.first[bin], places.room[bin]);
        let count = session.counted(Pointer { ..counted }.offset(bin), room);
        let shape = Shape::row(room.div_ceil(WARPS), WARPS * 32);
        let (patches, nets, basis) = (patches.pointer(), nets.pointer(), basis.pointer());
        let (meshlets, vertices) = (sorted.pointer().offset(first as usize), vertices.pointer());
        session.launch(&kernel.to_string(), shape, &[view, &patches, &meshlets, &nets, &basis, &vertices, &count])?;
    }
    Ok(())
}

/// The vertices of all meshlets of a frame's lists.
pub fn vertices<G: Gpu>(gpu: &mut G, staged: &Staged) -> Result<Vec<abi::Vertex>, GpuError> {
    let mut session = Session::new(gpu);
    let found = vertices_in(&mut session, staged);
    session.free()?;
    found
}

fn vertices_in<G: Gpu>(session: &mut Session<G>, staged: &Staged) -> Result<Vec<abi::Vertex>, GpuError> {
    let geometry = Geometry {
        view: staged.view,
        patches: session.upload(&staged.patches)?,
        leaves: session.upload(&staged.leaves)?,
        nets: session.upload(&staged.nets)?,
        basis: session.upload(&staged.basis)?,
        meshlets: List { buffer: session.upload(&staged.meshlets)?, count: Count::known(staged.meshlets.len() as u32) },
        vertices: None,
    };
    let vertices = session.allocate(staged.vertices)?;
    evaluate(session, &geometry, &vertices)?;
    session.download(&vertices)
}

pub(crate) fn view(lens: &Lens, options: &Options) -> abi::View {
    abi::View {
        eye: lens.eye.to_array(),
        axes: lens.axes.map(|axis| axis.to_array()),
        scale: lens.scale,
        near: lens.near,
        extent: lens.extent,
        near_f32: lens.near as f32,
        depth_slope: lens.depth_slope(),
        size: lens.size,
        perspective: lens.perspective.into(),
        projective: (options.bound.interpolation() == Interpolation::Projective).into(),
        tolerance: options.tolerance,
        depth_tolerance: options.depth_tolerance,
        fill: match options.fill {
            Fill::Stroke => abi::FillRule::FILL_STROKE,
            Fill::Eter => abi::FillRule::FILL_ETER,
            Fill::Conservative => abi::FillRule::FILL_CONSERVATIVE,
            Fill::Off => abi::FillRule::FILL_OFF,
        },
        refine: options.refine,
        trim: (options.trim != Trim::Off).into(),
        show: options.show as u32,
    }
}
