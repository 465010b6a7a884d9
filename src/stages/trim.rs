//! trim: fragments of meshlets that a trim curve crosses are tested on the exact surface (DESIGN section 5).
//!
//! A fragment's interpolated parameters may be half a pixel off. Where all parameters that near lie on one side, that
//! decides, for a whole triangle or for a block of pixels at once. Elsewhere the parameters are refined to the pixel's
//! centre before the test, so that both faces at an edge cut at the same place; a point outside but within the model's
//! own gap of a curve counts as inside, so that the faces meet. `--trim texture` looks its textures up instead, at each
//! fragment's interpolated parameters.

use super::estimate::Tessellation;
use super::evaluate::Meshlet;
use super::fill::is_tested_alone;
use super::frame::Targets;
use super::hardware::Routes;
use super::interpolate::Shown;
use super::newton::{Batch, LANES};
use super::rasterize::{BAND, Band, Bins, Coverage, faces_away, outlines};
use super::settle::EXACT;
use super::shade::Shader;
use super::stroke::{Pen, is_nearer};
use super::topology::{FOLD, Primitive, depth_of, index_of, meshlet_of, primitive, triangle_index, triangles, word};
use super::trim_cut::{Cut, keeps};
use super::trim_marks::{BLOCK, Line, Marks, Rows, each_bit, lines, lowest_run};
use super::trim_quad::Quad;
use super::{Fill, trim_texture};
use crate::cuda::abi;
use crate::scene::Region;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;

/// What trimming did in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TrimCounts {
    /// Meshlets of patches that loops cut: not drawn, drawn untested, tested.
    pub meshlets_outside: u64,
    pub meshlets_inside: u64,
    pub meshlets_boundary: u64,
    /// Fragments that were refined and tested, those of them that were rejected, and those left to the exact search.
    pub tested: u64,
    pub rejected: u64,
    pub proposed: u64,
    /// `--trim texture`: textures that would need more texels a side than they may have, so that the tolerance is missed; and
    /// memory of all textures.
    pub textures_too_coarse: u64,
    pub texture_bytes: u64,
}

impl TrimCounts {
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            meshlets_outside: self.meshlets_outside + other.meshlets_outside,
            meshlets_inside: self.meshlets_inside + other.meshlets_inside,
            meshlets_boundary: self.meshlets_boundary + other.meshlets_boundary,
            tested: self.tested + other.tested,
            rejected: self.rejected + other.rejected,
            proposed: self.proposed + other.proposed,
            textures_too_coarse: self.textures_too_coarse + other.textures_too_coarse,
            texture_bytes: self.texture_bytes + other.texture_bytes,
        }
    }
}

/// What one task needs to draw the tested meshlets of its band.
struct Trimmer<'a> {
    shader: &'a Shader<'a>,
    counts: TrimCounts,
    /// Fragments of the meshlet being drawn that have to be refined: pixel of the band, word.
    queue: Vec<(u32, u64)>,
    /// Fragments of the block being drawn, by row and column: those it has in common with `wins`.
    fragments: [[u64; BLOCK]; BLOCK],
    /// The curves near the triangle being drawn as lines on the screen.
    lines: Vec<Line>,
    /// Numbers of the curves, then of the lines that meet the blocks of pixels on the way down, one list behind the other.
    curves: Vec<u32>,
}

/// Draws the meshlets that trim curves cross into the buffers that `rasterize` left: those that hardware has not drawn, and
/// the fragments of others that it has listed.
pub(super) fn trim(
    shader: &Shader,
    pens: &[Pen],
    routes: &Routes,
    listed: &[abi::Fragment],
    targets: &mut Targets,
) -> TrimCounts {
    let width = shader.lens.size[0] as usize;
    let meshlets = &shader.meshlets.meshlets;
    // The nearest first: what they hide needs no test.
    let nearest = |m: &Meshlet| {
        let count = (usize::from(m.quads[0]) + 1) * (usize::from(m.quads[1]) + 1);
        let vertices = &shader.meshlets.vertices[m.vertices as usize..][..count];
        vertices.iter().fold(0.0f32, |depth, v| depth.max(v.depth))
    };
    let boundary = meshlets.iter().filter(|m| m.tested).count() as u64;
    let tested = meshlets.iter().enumerate().filter(|(_, m)| m.tested && !routes.draws(m));
    let mut order: Vec<(f32, u32)> = tested.map(|(k, m)| (nearest(m), k as u32)).collect();
    let textures = trim_texture::counts(&shader.textures);
    if boundary == 0 {
        return textures;
    }
    let listed = in_order(listed, (width * BAND) as u32);
    order.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let bins = Bins::new(meshlets, order.iter().map(|&(_, k)| k), (shader.lens.size[1] as usize).div_ceil(BAND));
    let bands = targets.near.par_chunks_mut(width * BAND).zip(targets.spare.par_chunks_mut(width * BAND));
    let bands = bands.zip(targets.touched.par_iter_mut()).enumerate();
    let counts = bands.map(|(k, ((near, spare), touched))| {
        let first = (k * BAND) as i32;
        let rows = [first, first + (near.len() / width) as i32];
        let mut band = Band { width: width as i32, rows, near, spare, touched, listed: None };
        let mut trimmer = Trimmer {
            shader,
            counts: TrimCounts::default(),
            queue: Vec::new(),
            fragments: [[0; BLOCK]; BLOCK],
            lines: Vec::new(),
            curves: Vec::new(),
        };
        for &number in bins.of(k) {
            trimmer.meshlet(number, pens, &mut band);
        }
        let first = (k * width * BAND) as u32;
        let from = listed.partition_point(|f| f.pixel < first);
        let of_band =
            &listed[from..from + listed[from..].partition_point(|f| f.pixel < first + band.near.len() as u32)];
        for fragments in of_band.chunk_by(|a, b| meshlet_of(a.word) == meshlet_of(b.word)) {
            trimmer.decide(fragments, first, &mut band);
        }
        trimmer.counts
    });
    let mut counts = counts.reduce(TrimCounts::default, TrimCounts::plus);
    counts.meshlets_boundary = boundary;
    counts.plus(textures)
}

/// By bands of so many pixels, and by meshlets in them: in one order, whatever order they were found in.
fn in_order(listed: &[abi::Fragment], band: u32) -> Vec<abi::Fragment> {
    let mut listed = listed.to_vec();
    listed.par_sort_unstable_by_key(|f| (f.pixel / band, meshlet_of(f.word), f.pixel, f.word));
    listed
}

impl Trimmer<'_> {
    /// Fragments of one meshlet in one band, which begins with the pixel `first`.
    fn decide(&mut self, fragments: &[abi::Fragment], first: u32, band: &mut Band) {
        let Shader { scene, lens, options, meshlets, leaves, .. } = *self.shader;
        let leaf = meshlets.meshlets[meshlet_of(fragments[0].word) as usize].leaf;
        let Some(cut) = Cut::new(scene, lens, options, &leaves[leaf as usize]) else { return };
        self.queue.extend(fragments.iter().map(|f| (f.pixel - first, f.word)));
        self.flush(&cut, leaf, band);
    }

    fn meshlet(&mut self, number: u32, pens: &[Pen], band: &mut Band) {
        let Shader { scene, lens, options, meshlets, leaves, grids, .. } = *self.shader;
        let meshlet = &meshlets.meshlets[number as usize];
        let leaf = &leaves[meshlet.leaf as usize];
        let Some(cut) = Cut::new(scene, lens, options, leaf) else { return };
        let Tessellation { quads, deviation: [deviation, _], .. } = grids[meshlet.leaf as usize];
        for a in 0..usize::from(meshlet.quads[0]) {
            for b in 0..usize::from(meshlet.quads[1]) {
                let first = triangle_index(meshlet, a, b);
                for (k, corners) in triangles(a, b, meshlet.diagonal).into_iter().enumerate() {
                    let vertices = corners.map(|[i, j]| meshlets.vertices[meshlet.vertex(i, j)]);
                    if faces_away(&vertices, meshlet.hidden) {
                        continue;
                    }
                    let Some(coverage) = Coverage::new(&vertices, band) else { continue };
                    let id = word(0.0, number, first + k as u32);
                    if let Some(texture) = self.shader.texture(meshlet.leaf) {
                        let [tested, rejected] = texture.draw(&Shown::new(meshlets, quads, id), &coverage, id, band);
                        self.counts.tested += tested;
                        self.counts.rejected += rejected;
                        continue;
                    }
                    if !coverage.wins(id, band) {
                        continue;
                    }
                    let spread = cut.spread(corners, &vertices, deviation);
                    let at = |k: usize, c: f64| (f64::from(meshlet.first[k]) + c) / f64::from(quads[k]);
                    let quad = Quad::new(
                        [at(0, a as f64), at(1, b as f64)],
                        [at(0, a as f64 + 1.0), at(1, b as f64 + 1.0)],
                        [0, 1].map(|k| spread[k] / f64::from(quads[k])),
                        corners.map(|[i, j]| [at(0, i as f64), at(1, j as f64)]),
                        &vertices,
                    );
                    let triangle = Triangle { cut: &cut, quad: &quad, coverage: &coverage, id, deviation };
                    self.triangle(&triangle, band);
                }
            }
        }
        self.flush(&cut, meshlet.leaf, band);
        band.listed = Some(Vec::new());
        outlines(meshlets, number, pens, options.fill, band);
        for (pixel, fragment) in band.listed.take().unwrap_or_default() {
            if self.keeps_stroke(&cut, meshlet, pixel, fragment, band) {
                band.spare_at(pixel, fragment);
            }
        }
    }

    /// A fragment for the spare buffer. One that stays as it is shows its own parameters, so that these are tested; one
    /// that only proposes a pixel is refused where nothing of the face is near.
    fn keeps_stroke(&mut self, cut: &Cut, meshlet: &Meshlet, pixel: u32, fragment: u64, band: &Band) -> bool {
        let Shader { options, meshlets, grids, .. } = *self.shader;
        // Fill wants nothing that N hides.
        if !is_nearer(fragment, band.near[pixel as usize]) {
            return false;
        }
        // A fold has no parameters of its own.
        if index_of(fragment) == FOLD {
            return true;
        }
        let s = self.shader.interpolated(meshlet.leaf, fragment, pixel + band.rows[0] as u32 * band.width as u32);
        let s = s.map(f64::from);
        if is_tested_alone(options) {
            let texture = self.shader.texture(meshlet.leaf);
            let keeps = texture.map_or_else(|| cut.tree.contains(cut.to_plane(s)), |texture| texture.contains(s));
            self.counts.tested += 1;
            self.counts.rejected += u64::from(!keeps);
            return keeps;
        }
        let Tessellation { quads, deviation: [deviation, _], .. } = grids[meshlet.leaf as usize];
        let (Primitive::Edge(corners) | Primitive::Triangle(corners)) = primitive(meshlet, index_of(fragment));
        let vertices = corners.map(|[i, j]| meshlets.vertices[meshlet.vertex(i, j)]);
        // The pen's width, and as much again to what lies under the pixel's centre.
        let spread = cut.spread(corners, &vertices, deviation);
        let spread = [0, 1].map(|k| 2.0 * spread[k] / f64::from(quads[k]));
        let near = [-1.0, 1.0].map(|sign| [0, 1].map(|k| s[k] + sign * spread[k]));
        // Edge-on there is no telling.
        !spread.iter().all(|s| s.is_finite()) || cut.classify(near[0], near[1]) != Region::Outside
    }

    /// Draws the part of a triangle that no trim curve comes near to, and queues the rest.
    fn triangle(&mut self, triangle: &Triangle, band: &mut Band) {
        let Triangle { cut, quad, coverage, id, deviation } = *triangle;
        let (low, high) = quad.parameters(coverage.pixels);
        let within = cut.plane_box(low, high);
        self.curves.clear();
        cut.tree.collect(&within, &mut self.curves);
        if self.curves.is_empty() {
            if cut.tree.contains(within.center()) {
                coverage.draw(coverage.pixels, id, band);
            }
            return;
        }
        let [low, high] = quad.rectangle().map(|corner| cut.to_plane(corner));
        let to_screen = quad.to_screen([low, high]);
        self.lines.clear();
        let reach = |gap: f64| cut.reach(deviation, gap);
        if !lines(&cut.tree, &self.curves, coverage.pixels, &to_screen, &within, reach, &mut self.lines) {
            let (queue, width) = (&mut self.queue, band.width as u32);
            return coverage
                .each(coverage.pixels, id, band, |_, [x, y], fragment| queue.push((y * width + x, fragment)));
        }
        self.curves.clear();
        self.curves.extend(0..self.lines.len() as u32);
        self.block(triangle, coverage.pixels, 0..self.lines.len(), band);
    }

    /// The same for a block of pixels, from large to small, each with the lines of the one before that come near to it.
    fn block(&mut self, triangle: &Triangle, block: [(i64, i64); 2], lines: Range<usize>, band: &mut Band) {
        let Triangle { cut, quad, coverage, id, .. } = *triangle;
        if !coverage.meets(block) {
            return;
        }
        let start = self.curves.len();
        for k in lines {
            let line = self.curves[k];
            if self.lines[line as usize].meets(block) {
                self.curves.push(line);
            }
        }
        let [(x0, x1), (y0, y1)] = block;
        let near = start..self.curves.len();
        if near.is_empty() {
            // Between two pixels of a triangle no curve passes then: one speaks for all.
            if coverage.first(block).is_some_and(|[x, y]| cut.tree.contains(cut.to_plane(quad.at(x, y)))) {
                coverage.draw(block, id, band);
            }
        } else if (x1 - x0).max(y1 - y0) < BLOCK as i64 {
            self.pixels(triangle, block, near, band);
        } else {
            let cut_in_two = |low: i64, high: i64| [(low, (low + high) / 2), ((low + high) / 2 + 1, high)];
            let halves = if x1 - x0 >= y1 - y0 {
                cut_in_two(x0, x1).map(|x| [x, (y0, y1)])
            } else {
                cut_in_two(y0, y1).map(|y| [(x0, x1), y])
            };
            for half in halves {
                self.block(triangle, half, near.clone(), band);
            }
        }
        self.curves.truncate(start);
    }

    /// The same for each pixel of a small block that the triangle would win: between neighbours that no curve comes near
    /// to none passes, so that one of them speaks for the other.
    fn pixels(&mut self, triangle: &Triangle, block: [(i64, i64); 2], lines: Range<usize>, band: &mut Band) {
        let Triangle { cut, quad, coverage, id, .. } = *triangle;
        let (width, top) = (band.width as u32, i64::from(band.rows[0]));
        let [(x0, _), (y0, y1)] = block;
        let fragments = &mut self.fragments;
        let mut wins: Rows = [0; BLOCK];
        let (left, upper) = (x0 as u32, (y0 - top) as u32);
        let first = upper * width + left;
        coverage.each(block, id, band, |_, [x, y], fragment| {
            let (row, column) = (y - upper, x - left);
            fragments[row as usize][column as usize] = fragment;
            wins[row as usize] |= 1 << column;
        });
        if wins == [0; BLOCK] {
            return;
        }
        let lines = self.curves[lines].iter().map(|&k| &self.lines[k as usize]);
        let marks = Marks::new(lines, [x0, y0]);
        let contains =
            |row: usize, column: u32| cut.tree.contains(cut.to_plane(quad.at(x0 + i64::from(column), y0 + row as i64)));
        let (mut known, mut inside) = (0u16, 0u16);
        for (row, &wins) in wins[..=(y1 - y0) as usize].iter().enumerate() {
            let pixel = first + row as u32 * width;
            each_bit(wins & marks.near[row], |column| {
                self.queue.push((pixel + column, fragments[row][column as usize]));
            });
            let mut here = 0;
            each_bit(wins & marks.beside[row] & !marks.near[row], |column| {
                here |= u16::from(contains(row, column)) << column;
            });
            let far = wins & !marks.beside[row];
            let above = [known & far, inside & far];
            (known, inside) = (far, 0);
            let mut rest = far;
            while rest != 0 {
                let run = lowest_run(rest);
                rest &= !run;
                let is_inside =
                    if run & above[0] != 0 { run & above[1] != 0 } else { contains(row, run.trailing_zeros()) };
                inside |= if is_inside { run } else { 0 };
            }
            each_bit(here | inside, |column| band.near[(pixel + column) as usize] = fragments[row][column as usize]);
        }
    }

    /// Refines what is queued, tests it and draws what passes.
    fn flush(&mut self, cut: &Cut, leaf: u32, band: &mut Band) {
        let shader = self.shader;
        let surface = shader.surface(leaf);
        let offset = band.rows[0] as u32 * band.width as u32;
        let mut queue = std::mem::take(&mut self.queue);
        // What other fragments of the meshlet hide by now goes first; all of it is decided again at the end.
        queue.retain(|&(pixel, fragment)| fragment > band.near[pixel as usize]);
        for fragments in queue.chunks(LANES) {
            let mut batch = Batch::default();
            for k in 0..LANES {
                let (pixel, fragment) = fragments[k.min(fragments.len() - 1)];
                [batch.s[k], batch.t[k]] = shader.interpolated(leaf, fragment, pixel + offset);
                [batch.x[k], batch.y[k]] = shader.target(&shader.leaves[leaf as usize], pixel + offset);
            }
            let rounds = shader.options.refine;
            shader.refine(&surface, rounds, &mut batch);
            for (k, &(pixel, fragment)) in fragments.iter().enumerate() {
                self.counts.tested += 1;
                if keeps(shader, leaf, cut, &surface, &batch, k) {
                    let near = &mut band.near[pixel as usize];
                    *near = (*near).max(fragment);
                    continue;
                }
                self.counts.rejected += 1;
                // It was not tested under the pixel's centre: whatever surface lies there is searched for.
                let undecided = batch.residual[k] > EXACT && rounds > 0;
                if undecided && shader.options.fill == Fill::Stroke {
                    self.counts.proposed += 1;
                    band.spare_at(pixel, word(depth_of(fragment), meshlet_of(fragment), FOLD));
                }
            }
        }
        queue.clear();
        self.queue = queue;
    }
}

/// A triangle that trim curves may cross.
struct Triangle<'a> {
    cut: &'a Cut<'a>,
    quad: &'a Quad,
    coverage: &'a Coverage,
    /// Its word without depth.
    id: u64,
    /// Pixels that its grid is off by.
    deviation: f32,
}
