//! shade: the exact surface under every pixel, and its colour (DESIGN section 4; ETER's SHD).

use super::cull::Leaf;
use super::estimate::Tessellation;
use super::evaluate::Meshlets;
use super::fill::Filled;
use super::frame::Targets;
use super::interpolate::{Shown, interpolate};
use super::lens::Lens;
use super::light::{Light, Seen, light};
use super::newton::{Batch, LANES, Surface, refine};
use super::rasterize::BAND;
use super::settle::{Doubt, DoubtKind, EXACT, refuse, resettle, settle};
use super::topology::{depth_of, meshlet_of, with_depth};
use super::trim_cut::gaps;
use super::trim_texture::Texture;
use super::{Fill, Options, Show, show};
use crate::geometry::root;
use crate::scene::Scene;
use fearless_simd::{Level, dispatch};
use glam::Vec4;
use rayon::prelude::*;

/// Everything that shading reads.
pub(super) struct Shader<'a> {
    pub scene: &'a Scene,
    pub lens: &'a Lens,
    pub options: &'a Options,
    pub meshlets: &'a Meshlets,
    pub leaves: &'a [Leaf],
    pub nets: &'a [Vec4],
    pub grids: &'a [Tessellation],
    /// Of `--trim texture`, by leaf; else empty.
    pub textures: Vec<Option<Texture>>,
}

/// Pixels of rounding that refinement may meet where it follows a net past its leaf, into the rest of the patch.
const EXTRAPOLATED: f64 = 1.0 / 128.0;
/// Of stored depths, as a share of the camera depth (perspective) or of the depth range.
const DEPTH_ROUNDING: f64 = 8.0 * f32::EPSILON as f64;

/// Parameters so near to a patch's border are on it.
const BORDER: f64 = 1e-6;

/// Pixels in a row that show one leaf.
struct Run {
    leaf: u32,
    first: u32,
    count: u32,
}

/// Shades every drawn pixel; filled pixels that turn out to be no gap go back to N.
pub(super) fn shade(shader: &Shader, targets: &mut Targets, filled: &mut Vec<Filled>) {
    let exact = shader.options.refine > 0 && shader.options.fill == Fill::Stroke;
    // Between whole patches the grids' depth decides well enough, and for nothing.
    let doubtful = exact && shader.scene.trims.segments() > 0;
    if exact {
        settle(shader, targets, filled);
    } else if shader.options.refine > 0 {
        refuse(shader, targets, filled);
    }
    let width = shader.lens.size[0] as usize;
    let bands = targets.near.par_chunks(width * BAND).zip(targets.parameters.par_chunks_mut(width * BAND));
    let bands = bands.zip(targets.color.par_chunks_mut(width * BAND)).enumerate();
    let doubts = bands.map(|(k, ((words, parameters), color))| {
        let first = (k * BAND * width) as u32;
        let mut doubts = Vec::new();
        for group in shader.runs(words).chunk_by(|a, b| a.leaf == b.leaf) {
            shader.group(group, words, first, &mut |pixel, surfel| {
                parameters[pixel] = surfel.parameters;
                color[pixel] = surfel.color;
                if doubtful && let Some(kind) = shader.doubt(group[0].leaf, words[pixel], &surfel) {
                    let near = with_depth(words[pixel], surfel.depth);
                    let start = (kind == DoubtKind::Deep).then_some(surfel.parameters);
                    doubts.push(Doubt { filled: Filled { pixel: first + pixel as u32, near, start }, kind });
                }
            });
        }
        doubts
    });
    let mut doubts: Vec<Doubt> = doubts.flatten().collect();
    doubts.sort_unstable_by_key(|d| d.filled.pixel);
    doubts.retain(|d| filled.binary_search_by_key(&d.filled.pixel, |f| f.pixel).is_err());
    resettle(shader, targets, &doubts, filled);
    // Where a filled pixel's parameters are known, they stand: its triangle would lead astray near a silhouette.
    let near = &targets.near;
    let surfels: Vec<Surfel> = filled.par_iter().map(|f| shader.surfel(near[f.pixel as usize], f)).collect();
    for (f, surfel) in filled.iter().zip(surfels) {
        targets.parameters[f.pixel as usize] = surfel.parameters;
        targets.color[f.pixel as usize] = surfel.color;
    }
    // Words may have got the depth of the exact surface since they were painted.
    if shader.options.show == Show::Depth {
        repaint(shader, targets);
    }
}

/// Parameters of a leaf that lie in its patch. Outside its unit square a net's rounding grows like (1 + 2 a)^(m + n) with the
/// distance a: no farther out than where it could be seen.
pub(crate) fn domain(leaf: &Leaf) -> [[f32; 2]; 2] {
    let out = (root(EXTRAPOLATED / leaf.rounding, leaf.degree[0] + leaf.degree[1]) - 1.0).max(0.0) * 0.5;
    [0, 1].map(|k| {
        let end = |value: f64| ((value - leaf.corner[k]) / leaf.extent[k]).clamp(-out, 1.0 + out) as f32;
        [end(0.0), end(1.0)]
    })
}

/// What refinement may change a leaf's depth beyond the surface's own slope, model units.
pub(crate) fn depth_tolerance(lens: &Lens, options: &Options, leaf: &Leaf) -> f32 {
    (options.depth_tolerance * lens.pixel_size(leaf.low.z)) as f32
}

/// Colours every pixel of a finished frame anew, where its parameters are.
pub(super) fn repaint(shader: &Shader, targets: &mut Targets) {
    let Targets { near, parameters, color, .. } = targets;
    color.par_iter_mut().enumerate().filter(|&(pixel, _)| near[pixel] != 0).for_each(|(pixel, color)| {
        let start = Some(parameters[pixel]);
        *color = shader.surfel(near[pixel], &Filled { pixel: pixel as u32, near: 0, start }).color;
    });
}

/// One shaded pixel.
pub(super) struct Surfel {
    parameters: [f32; 2],
    color: [f32; 3],
    /// Pixels between the pixel centre and the projected surface point.
    pub residual: f32,
    /// Stored depth of the surface point.
    depth: f32,
    /// It is the inside of a solid: another sheet is in front.
    away: bool,
}

impl Shader<'_> {
    /// Runs of pixels of one leaf, sorted by leaf; background left out.
    fn runs(&self, words: &[u64]) -> Vec<Run> {
        let width = self.lens.size[0] as usize;
        let mut runs: Vec<Run> = Vec::new();
        for (row, words) in words.chunks(width).enumerate() {
            let start = (row * width) as u32;
            // 0 is background and no meshlet's word: depth is positive.
            let mut previous = (u64::MAX, u32::MAX);
            for (x, &word) in words.iter().enumerate() {
                if word == 0 {
                    previous = (u64::MAX, u32::MAX);
                    continue;
                }
                let meshlet = u64::from(meshlet_of(word));
                let leaf =
                    if meshlet == previous.0 { previous.1 } else { self.meshlets.meshlets[meshlet as usize].leaf };
                match runs.last_mut() {
                    Some(run) if leaf == previous.1 => run.count += 1,
                    _ => runs.push(Run { leaf, first: start + x as u32, count: 1 }),
                }
                previous = (meshlet, leaf);
            }
        }
        runs.sort_unstable_by_key(|run| (run.leaf, run.first));
        runs
    }

    /// Shades the pixels of one leaf in batches.
    fn group(&self, runs: &[Run], words: &[u64], first: u32, write: &mut impl FnMut(usize, Surfel)) {
        let leaf = runs[0].leaf;
        let surface = self.surface(leaf);
        let mut pixels = runs.iter().flat_map(|run| run.first..run.first + run.count);
        let mut batch = [0u32; LANES];
        let (quads, width) = (self.grids[leaf as usize].quads, self.lens.size[0]);
        // Neighbours mostly show the same triangle.
        let mut last = None;
        loop {
            let mut count = 0;
            for slot in &mut batch {
                let Some(pixel) = pixels.next() else { break };
                *slot = pixel;
                count += 1;
            }
            if count == 0 {
                break;
            }
            let word = |k: usize| words[batch[k] as usize];
            let pixels = &batch.map(|p| p + first)[..count];
            let start = |k: usize| {
                let (pixel, triangle) = (pixels[k], word(k) as u32);
                if last.as_ref().is_none_or(|&(of, _)| of != triangle) {
                    last = Some((triangle, Shown::new(self.meshlets, quads, word(k))));
                }
                last.as_ref().map_or([0.0; 2], |(_, shown)| shown.at(pixel % width, pixel / width))
            };
            self.batch(&surface, leaf, pixels, start, word, &mut |k, surfel| write(batch[k] as usize, surfel));
        }
    }

    pub(super) fn surface(&self, leaf: u32) -> Surface<'_> {
        let leaf = &self.leaves[leaf as usize];
        Surface {
            net: &self.nets[leaf.net as usize..leaf.net as usize + leaf.points()],
            degree: leaf.degree,
            rational: self.scene.patches[leaf.patch as usize].rational,
            perspective: self.lens.perspective,
            depth_origin: leaf.depth_origin as f32,
            rounding: leaf.rounding as f32,
            domain: domain(leaf),
            any_sheet: false,
            depth_tolerance: depth_tolerance(self.lens, self.options, leaf),
        }
    }

    /// Up to eight pixels of one leaf: interpolated, refined, coloured.
    fn batch(
        &self,
        surface: &Surface,
        number: u32,
        pixels: &[u32],
        mut start: impl FnMut(usize) -> [f32; 2],
        word: impl Fn(usize) -> u64,
        write: &mut impl FnMut(usize, Surfel),
    ) {
        let leaf = &self.leaves[number as usize];
        let mut lanes = Batch::default();
        for k in 0..LANES {
            // Lanes to spare repeat the last pixel: same arithmetic, no special case.
            let j = k.min(pixels.len() - 1);
            [lanes.s[k], lanes.t[k]] = start(j);
            [lanes.x[k], lanes.y[k]] = self.target(leaf, pixels[j]);
        }
        self.refine(surface, self.options.refine, &mut lanes);
        let width = self.lens.size[0];
        let places = std::array::from_fn(|k| pixels[k.min(pixels.len() - 1)]).map(|p| [p % width, p / width]);
        let seen = Seen { lens: self.lens, center: leaf.center, pixels: places };
        let mut lit = Light::default();
        let level = Level::new();
        dispatch!(level, simd => light(simd, &seen, &lanes, &mut lit));
        for (k, &pixel) in pixels.iter().enumerate() {
            let parameters = [lanes.s[k], lanes.t[k]];
            let look = show::Look { number, parameters, word: word(k), pixel, light: &lit, lane: k };
            let depth = self.stored_depth(surface.depth_origin + lanes.z[k]);
            let (residual, away) = (lanes.residual[k], lanes.faces_away(k, leaf.hidden));
            write(k, Surfel { parameters, color: show::color(self, &look), residual, depth, away });
        }
    }

    /// A pixel's centre about the leaf's.
    pub(super) fn target(&self, leaf: &Leaf, pixel: u32) -> [f32; 2] {
        let [width, height] = self.lens.size;
        let (x, y) = ((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        [x - width as f32 * 0.5 - leaf.center[0] as f32, y - height as f32 * 0.5 - leaf.center[1] as f32]
    }

    pub(super) fn refine(&self, surface: &Surface, rounds: u32, batch: &mut Batch) {
        let level = Level::new();
        dispatch!(level, simd => refine(simd, surface, rounds, batch));
    }

    pub(super) fn stored_depth(&self, z: f32) -> f32 {
        let lens = self.lens;
        if lens.perspective { lens.near as f32 / z } else { 1.0 - (z - lens.near as f32) / lens.extent as f32 }
    }

    /// A stored depth that is nearer by so many depth tolerances; 0 for background.
    pub(super) fn nearer_by_tolerance(&self, stored: f32, times: f64) -> f32 {
        let lens = self.lens;
        if stored == 0.0 {
            return 0.0;
        }
        let z = if lens.perspective {
            lens.near / f64::from(stored)
        } else {
            lens.near + (1.0 - f64::from(stored)) * lens.extent
        };
        self.stored_depth((z - times * self.options.depth_tolerance * lens.pixel_size(z)) as f32)
    }

    /// A stored depth, farther by so many model units.
    pub(super) fn farther(&self, stored: f32, by: f64) -> f64 {
        let (lens, stored) = (self.lens, f64::from(stored));
        if lens.perspective { stored / (1.0 + stored * by / lens.near) } else { stored - by / lens.extent }
    }

    /// The exact point is not where the grid's depth said, or not under the pixel's centre: on steep surfaces half a
    /// pixel is many pixels deep, and the depth test was not fair.
    fn doubt(&self, leaf: u32, word: u64, surfel: &Surfel) -> Option<DoubtKind> {
        let lens = self.lens;
        let shown = f64::from(depth_of(word));
        let (pixel, range) =
            if lens.perspective { (shown / lens.scale, shown) } else { (1.0 / (lens.scale * lens.extent), 1.0) };
        let off = (f64::from(surfel.depth) - shown).abs();
        if !(surfel.depth > 0.0 && surfel.depth.is_finite()) {
            return None;
        }
        if surfel.residual > EXACT {
            let leaf = &self.leaves[leaf as usize];
            let uv = leaf.to_patch(surfel.parameters.map(f64::from));
            let ended = uv.iter().any(|c| !(BORDER..=1.0 - BORDER).contains(c));
            // As far as the model's own gap reaches, the border stands for what is missing.
            let gap = gaps(self.scene, self.lens, leaf)[1] as f32;
            return Some(if ended && surfel.residual > gap + EXACT { DoubtKind::Ended } else { DoubtKind::Beside });
        }
        // Between whole patches the grids' depth decides well enough, and for nothing.
        if surfel.away {
            return Some(DoubtKind::Beside);
        }
        let deep = off > self.options.depth_tolerance * pixel + DEPTH_ROUNDING * range;
        deep.then_some(DoubtKind::Deep)
    }

    pub(super) fn interpolated(&self, leaf: u32, word: u64, pixel: u32) -> [f32; 2] {
        let width = self.lens.size[0];
        interpolate(self.meshlets, self.grids[leaf as usize].quads, word, pixel % width, pixel / width)
    }

    /// Of a leaf, by `--trim texture`.
    pub(super) fn texture(&self, leaf: u32) -> Option<&Texture> {
        self.textures.get(leaf as usize)?.as_ref()
    }

    /// A filled pixel as if it showed `word`.
    pub(super) fn surfel(&self, word: u64, filled: &Filled) -> Surfel {
        let leaf = self.meshlets.meshlets[meshlet_of(word) as usize].leaf;
        let start = filled.start.unwrap_or_else(|| self.interpolated(leaf, word, filled.pixel));
        let mut found =
            Surfel { parameters: [0.0; 2], color: [0.0; 3], residual: f32::INFINITY, depth: 0.0, away: false };
        self.batch(&self.surface(leaf), leaf, &[filled.pixel], |_| start, |_| word, &mut |_, surfel| found = surfel);
        found
    }
}
