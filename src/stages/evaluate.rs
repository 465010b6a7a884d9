//! evaluate: the vertices of every meshlet (ETER's EVAL).

use super::basis::BasisTables;
use super::cull::Leaf;
use super::estimate::{MESHLET, Tessellation};
use super::lens::Lens;
use super::trim_cut::{self, Cut, MAX_GAP};
use super::{Interpolation, Options, TrimCounts};
use crate::scene::{Region, Scene};
use glam::Vec4;

/// Sub-pixel steps a pixel: 8 bits.
pub(super) const SUBPIXELS: i32 = crate::cuda::abi::SUBPIXELS;

/// A projected vertex, snapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Vertex {
    /// Sub-pixel position from the image's top left corner.
    pub x: i32,
    pub y: i32,
    /// Stored depth: larger is nearer, in (0, 1].
    pub depth: f32,
    /// Weight of this vertex's parameters at a pixel, as the bound's interpolation asks for.
    pub weight: f32,
}

/// A block of at most 7 x 7 quads of one leaf's grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meshlet {
    pub leaf: u32,
    /// Its (quads_u + 1)(quads_v + 1) vertices, u outermost.
    pub vertices: u32,
    /// Its first quad in the leaf's grid.
    pub first: [u16; 2],
    pub quads: [u8; 2],
    pub diagonal: u8,
    /// `Leaf::hidden`.
    pub hidden: i8,
    /// A trim curve crosses it, or comes near: trim.rs draws its triangles.
    pub tested: bool,
    /// Which of its sides (u=0, u=1, v=0, v=1) are the leaf's, or where the next meshlet is trimmed away: bits 0 to 3.
    pub outer: u8,
    /// Columns and rows of pixels it may touch, strokes included: first and one past the last.
    pub columns: [u16; 2],
    pub rows: [u16; 2],
}

/// What evaluate hands on, for any number of leaves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Meshlets {
    pub meshlets: Vec<Meshlet>,
    pub vertices: Vec<Vertex>,
    pub quads: u64,
    pub trim: TrimCounts,
}

impl Meshlets {
    /// Moves another list behind this one.
    pub fn append(&mut self, other: Meshlets) {
        let offset = self.vertices.len() as u32;
        self.meshlets.extend(other.meshlets.into_iter().map(|m| Meshlet { vertices: m.vertices + offset, ..m }));
        self.vertices.extend(other.vertices);
        self.quads += other.quads;
        self.trim = self.trim.plus(other.trim);
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.meshlets[..]) + size_of_val(&self.vertices[..])
    }
}

impl Meshlet {
    pub fn vertex(&self, i: usize, j: usize) -> usize {
        self.vertices as usize + i * (self.quads[1] as usize + 1) + j
    }
}

/// Evaluates the leaves' grids; meshlets come in leaf order, blocks in parameter order.
pub(super) fn evaluate(
    view: &View,
    tables: &BasisTables,
    leaves: &[Leaf],
    nets: &[Vec4],
    first_leaf: usize,
    grids: &[Tessellation],
) -> Meshlets {
    let mut out = Meshlets::default();
    let mut evaluator = Evaluator { view, columns: Vec::new(), dropped: Vec::new() };
    for (k, (leaf, grid)) in leaves.iter().zip(grids).enumerate() {
        let net = &nets[leaf.net as usize..leaf.net as usize + leaf.points()];
        tables.with(leaf.degree[0], grid.quads[0], |basis_u| {
            tables.with(leaf.degree[1], grid.quads[1], |basis_v| {
                evaluator.leaf(leaf, (first_leaf + k) as u32, grid, net, [basis_u, basis_v], &mut out);
            });
        });
    }
    out
}

/// What is looked at, and how.
pub(super) struct View<'a> {
    pub scene: &'a Scene,
    pub lens: &'a Lens,
    pub options: &'a Options,
}

struct Evaluator<'a> {
    view: &'a View<'a>,
    columns: Vec<Vec4>,
    /// The blocks of the leaf that lie outside its trims, v innermost; empty where nothing cuts it.
    dropped: Vec<bool>,
}

impl Evaluator<'_> {
    fn leaf(
        &mut self,
        leaf: &Leaf,
        number: u32,
        grid: &Tessellation,
        net: &[Vec4],
        basis: [&[f32]; 2],
        out: &mut Meshlets,
    ) {
        let View { scene, lens, options } = *self.view;
        let shape = Projector::new(lens, leaf, options.bound.interpolation());
        let cut = Cut::new(scene, lens, options, leaf);
        self.drop_blocks(cut.as_ref(), grid);
        let columns = blocks(grid.quads[1]).count();
        let dropped = |a: usize, b: usize| self.dropped.get(a * columns + b).copied().unwrap_or(false);
        // A side is outer where the leaf ends and where the next block is not drawn.
        let outer = |a: usize, b: usize, first: [u32; 2], end: [u32; 2]| {
            u8::from(first[0] == 0 || dropped(a.wrapping_sub(1), b))
                | u8::from(end[0] == grid.quads[0] || dropped(a + 1, b)) << 1
                | u8::from(first[1] == 0 || dropped(a, b - 1)) << 2
                | u8::from(end[1] == grid.quads[1] || dropped(a, b + 1)) << 3
        };
        // What fragments are off by, or strokes reach: conservative ones half a pixel.
        let reach = f64::from(grid.deviation[0]).max(0.5 * self.view.options.tolerance).max(0.5) + MAX_GAP;
        let size = self.view.lens.size;
        let touched = |axis: usize, vertices: &[Vertex], place: fn(&Vertex) -> i32| {
            touched(vertices.iter().map(place), reach.ceil() as i32, size[axis])
        };
        let mut columns_of = std::mem::take(&mut self.columns);
        for (a, (first_u, quads_u)) in blocks(grid.quads[0]).enumerate() {
            for (b, (first_v, quads_v)) in blocks(grid.quads[1]).enumerate() {
                if dropped(a, b) {
                    out.trim.meshlets_outside += 1;
                    continue;
                }
                let start = out.vertices.len();
                for i in first_u..=first_u + quads_u {
                    collapse(&mut columns_of, net, leaf.degree, basis[0], i as usize);
                    for j in first_v..=first_v + quads_v {
                        let row = leaf.degree[1] + 1;
                        let b = &basis[1][j as usize * row..(j as usize + 1) * row];
                        let point = columns_of.iter().zip(b).fold(Vec4::ZERO, |sum, (&c, &b)| sum + c * b);
                        out.vertices.push(shape.vertex(point));
                    }
                }
                let mut meshlet = Meshlet {
                    leaf: number,
                    vertices: start as u32,
                    first: [first_u as u16, first_v as u16],
                    quads: [quads_u as u8, quads_v as u8],
                    diagonal: grid.diagonal,
                    hidden: leaf.hidden,
                    tested: false,
                    outer: outer(a, b, [first_u, first_v], [first_u + quads_u, first_v + quads_v]),
                    columns: touched(0, &out.vertices[start..], |v| v.x),
                    rows: touched(1, &out.vertices[start..], |v| v.y),
                };
                if let Some(cut) = &cut {
                    match trim_cut::region(cut, grid, &meshlet, &out.vertices[start..]) {
                        Region::Inside => out.trim.meshlets_inside += 1,
                        Region::Boundary => meshlet.tested = true,
                        Region::Outside => {
                            out.trim.meshlets_outside += 1;
                            out.vertices.truncate(start);
                            continue;
                        }
                    }
                }
                out.quads += u64::from(quads_u * quads_v);
                out.meshlets.push(meshlet);
            }
        }
        self.columns = columns_of;
    }

    /// Finds the blocks that lie outside the trims: they are not even evaluated.
    fn drop_blocks(&mut self, cut: Option<&Cut>, grid: &Tessellation) {
        self.dropped.clear();
        let Some(cut) = cut else { return };
        let at = |k: usize, line: u32| f64::from(line) / f64::from(grid.quads[k]);
        for (first_u, quads_u) in blocks(grid.quads[0]) {
            for (first_v, quads_v) in blocks(grid.quads[1]) {
                let low = [at(0, first_u), at(1, first_v)];
                let high = [at(0, first_u + quads_u), at(1, first_v + quads_v)];
                self.dropped.push(cut.classify(low, high) == Region::Outside);
            }
        }
    }
}

/// The columns or rows of pixels that vertices at these places may touch, `reach` pixels about them: first and one past the
/// last.
fn touched(places: impl Iterator<Item = i32>, reach: i32, size: u32) -> [u16; 2] {
    let (low, high) = places.fold((i32::MAX, i32::MIN), |(low, high), place| (low.min(place), high.max(place)));
    let [low, high] = [low.div_euclid(SUBPIXELS) - reach, high.div_euclid(SUBPIXELS) + 1 + reach];
    [low, high].map(|end| end.clamp(0, size as i32) as u16)
}

/// Sums the net over u on grid line i: one point per column of the net.
fn collapse(columns: &mut Vec<Vec4>, net: &[Vec4], [m, n]: [usize; 2], basis: &[f32], i: usize) {
    columns.clear();
    columns.resize(n + 1, Vec4::ZERO);
    for (row, &b) in net.chunks_exact(n + 1).zip(&basis[i * (m + 1)..(i + 1) * (m + 1)]) {
        for (column, &point) in columns.iter_mut().zip(row) {
            *column += point * b;
        }
    }
}

/// Projection of points of one leaf.
struct Projector {
    /// Sub-pixel position of the leaf's centre.
    base: [i32; 2],
    depth_origin: f32,
    perspective: bool,
    projective: bool,
    near: f32,
    /// Orthographic depth: `offset - slope * Z / w`.
    offset: f32,
    slope: f32,
}

impl Projector {
    fn new(lens: &Lens, leaf: &Leaf, interpolation: Interpolation) -> Self {
        Self {
            base: lens.base(leaf.center),
            depth_origin: leaf.depth_origin as f32,
            perspective: lens.perspective,
            projective: interpolation == Interpolation::Projective,
            near: lens.near as f32,
            offset: lens.depth_offset(leaf.depth_origin),
            slope: lens.depth_slope(),
        }
    }

    fn vertex(&self, p: Vec4) -> Vertex {
        let denominator = if self.perspective { p.z + self.depth_origin * p.w } else { p.w };
        let x = self.base[0] + (p.x / denominator * SUBPIXELS as f32).round_ties_even() as i32;
        let y = self.base[1] + (p.y / denominator * SUBPIXELS as f32).round_ties_even() as i32;
        let depth =
            if self.perspective { self.near * p.w / denominator } else { self.offset - self.slope * (p.z / p.w) };
        // A hull that touches the near plane may round past it.
        let depth = depth.clamp(f32::MIN_POSITIVE, 1.0);
        let weight = match (self.projective, self.perspective) {
            (false, true) => depth,
            (false, false) => 1.0,
            (true, _) => 1.0 / denominator,
        };
        Vertex { x, y, depth, weight }
    }
}

/// Cuts a side of `quads` into the fewest blocks of at most 7, as even as they go: first quad and number.
fn blocks(quads: u32) -> impl Iterator<Item = (u32, u32)> + Clone {
    let count = quads.div_ceil(MESHLET);
    let size = quads.div_ceil(count);
    (0..quads.div_ceil(size)).map(move |k| (k * size, size.min(quads - k * size)))
}
