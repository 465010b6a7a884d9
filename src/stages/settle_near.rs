//! Part of shade: which triangles come near to given pixels, and so high there that their surface may be nearer to the eye
//! than some depth.
//!
//! A surface point under a pixel's centre has its triangle's point of the same parameters within the grid's deviation, on
//! the screen and in depth. So all triangles are drawn once more, wider by that, on the pixels in question alone.

use super::evaluate::{Meshlet, SUBPIXELS, Vertex};
use super::fill::Filled;
use super::rasterize::{BAND, Bins, Triangle, pixel_range, span};
use super::settle::EXACT;
use super::shade::Shader;
use super::topology::{triangle_index, triangles, word};
use super::trim_cut;
use rayon::prelude::*;
use std::ops::Range;

const HALF: i64 = SUBPIXELS as i64 / 2;
/// What rounding may take of a stored depth, as a share of it.
const ROUNDING: f64 = 1e-6;

/// A triangle near a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Candidate {
    pub leaf: u32,
    /// Number of the pixel in its band's list.
    pub slot: u32,
    /// As a visibility word without depth.
    pub word: u64,
}

/// Calls `settle` for each band of the image that has some of `pixels`, sorted by place in the image, with these pixels
/// and all candidates, sorted; hands on what it returns, a value a pixel, in order. `behind`: the stored depth, by pixel,
/// that a surface has to be nearer than.
pub(super) fn by_band<T: Send>(
    shader: &Shader,
    pixels: &[Filled],
    behind: &[f32],
    settle: impl Fn(Range<usize>, &[Candidate]) -> Vec<T> + Sync,
) -> Vec<T> {
    let [width, height] = shader.lens.size;
    let meshlets = &shader.meshlets.meshlets;
    let bins = Bins::new(meshlets, 0..meshlets.len() as u32, (height as usize).div_ceil(BAND));
    let from = |row: u32| pixels.partition_point(|f| f.pixel < row * width);
    let band = |k: usize| {
        let rows = [k * BAND, ((k + 1) * BAND).min(height as usize)].map(|row| row as u32);
        let range = from(rows[0])..from(rows[1]);
        if range.is_empty() {
            return Vec::new();
        }
        let mut before = vec![0; width as usize + 1];
        pixels[range.clone()].iter().for_each(|f| before[(f.pixel % width) as usize + 1] += 1);
        (0..width as usize).for_each(|x| before[x + 1] += before[x]);
        let mut wanted = Wanted { shader, first: rows[0], rows: Vec::new(), before, found: Vec::new() };
        for row in rows[0]..rows[1] {
            let range = from(row)..from(row + 1);
            let start = (range.start - from(rows[0])) as u32;
            let columns = pixels[range.clone()].iter().map(|f| f.pixel % width);
            wanted.rows.push(Row::new(start, width, columns.zip(behind[range].iter().copied())));
        }
        for &number in bins.of(k) {
            wanted.meshlet(number);
        }
        wanted.found.sort_unstable();
        settle(range, &wanted.found)
    };
    (0..(height as usize).div_ceil(BAND)).into_par_iter().flat_map_iter(band).collect()
}

/// One band's pixels.
struct Wanted<'a> {
    shader: &'a Shader<'a>,
    /// The band's first row.
    first: u32,
    rows: Vec<Row>,
    /// How many of them lie in the columns before each.
    before: Vec<u32>,
    found: Vec<Candidate>,
}

/// One row's pixels.
struct Row {
    /// Number of its first pixel.
    start: u32,
    /// Columns, ascending, with the depths to be nearer than.
    pixels: Vec<(u32, f32)>,
    /// A bit for each of the image's columns, and how many are set in the words before.
    bits: Vec<(u64, u32)>,
}

impl Row {
    fn new(start: u32, width: u32, pixels: impl Iterator<Item = (u32, f32)>) -> Self {
        let mut row = Self { start, pixels: pixels.collect(), bits: vec![(0, 0); width as usize / 64 + 1] };
        row.pixels.iter().for_each(|&(x, _)| row.bits[x as usize / 64].0 |= 1 << (x % 64));
        let mut before = 0;
        for (bits, count) in &mut row.bits {
            *count = before;
            before += bits.count_ones();
        }
        row
    }

    /// The places of some columns in the list.
    fn columns(&self, (low, high): (i64, i64)) -> Range<usize> {
        self.before(low)..self.before(high + 1)
    }

    /// How many pixels come before a column.
    fn before(&self, column: i64) -> usize {
        let column = column.max(0) as usize;
        let after = self.pixels.len();
        self.bits.get(column / 64).map_or(after, |&(bits, before)| {
            before as usize + (bits & ((1 << (column % 64)) - 1)).count_ones() as usize
        })
    }
}

impl Wanted<'_> {
    fn meshlet(&mut self, number: u32) {
        let Shader { scene, lens, meshlets, leaves, grids, .. } = *self.shader;
        let meshlet = &meshlets.meshlets[number as usize];
        let leaf = &leaves[meshlet.leaf as usize];
        let [pixels, depth] = grids[meshlet.leaf as usize].deviation.map(f64::from);
        // Within the model's gap the border stands in for what is missing.
        if self.nothing_near(meshlet) {
            return;
        }
        let gap = trim_cut::gaps(scene, lens, leaf)[1];
        let reach = ((pixels + gap + f64::from(EXACT)) * f64::from(SUBPIXELS)).ceil() as i64;
        for a in 0..usize::from(meshlet.quads[0]) {
            for b in 0..usize::from(meshlet.quads[1]) {
                for (k, corners) in triangles(a, b, meshlet.diagonal).into_iter().enumerate() {
                    let vertices = corners.map(|[i, j]| meshlets.vertices[meshlet.vertex(i, j)]);
                    let word = word(0.0, number, triangle_index(meshlet, a, b) + k as u32);
                    self.triangle(&vertices, reach, depth, Candidate { leaf: meshlet.leaf, slot: 0, word });
                }
            }
        }
    }

    /// No pixel lies in the box that the meshlet may touch.
    fn nothing_near(&self, meshlet: &Meshlet) -> bool {
        let ends = |[low, high]: [u16; 2]| (i64::from(low), i64::from(high) - 1);
        let (x, y) = (ends(meshlet.columns), ends(meshlet.rows));
        self.none_in(x) || self.rows_of(y).all(|(_, row)| self.rows[row].columns(x).is_empty())
    }

    /// No pixel lies in these columns; most boxes are told by that alone.
    fn none_in(&self, (low, high): (i64, i64)) -> bool {
        let last = self.before.len() as i64 - 2;
        let (low, high) = (low.max(0), high.min(last));
        low > high || self.before[low as usize] == self.before[high as usize + 1]
    }

    /// The band's rows among some of the image's, with their places in the band.
    fn rows_of(&self, (low, high): (i64, i64)) -> impl Iterator<Item = (i64, usize)> + use<> {
        let first = i64::from(self.first);
        (low.max(first)..=high.min(first + self.rows.len() as i64 - 1)).map(move |y| (y, (y - first) as usize))
    }

    fn triangle(&mut self, vertices: &[Vertex; 3], reach: i64, depth: f64, candidate: Candidate) {
        let ends = |v: [i32; 3]| {
            let v = v.map(i64::from);
            pixel_range(v[0].min(v[1]).min(v[2]) - reach, v[0].max(v[1]).max(v[2]) + reach)
        };
        let x = ends(vertices.map(|v| v.x));
        if self.none_in(x) {
            return;
        }
        let mut drawn = None;
        for (y, row) in self.rows_of(ends(vertices.map(|v| v.y))) {
            let row = &self.rows[row];
            let near = row.columns(x);
            if near.is_empty() {
                continue;
            }
            let (t, plane) = drawn.get_or_insert_with(|| {
                let t = Triangle::new(vertices);
                (t, Plane::new(&t, reach))
            });
            let [first, last] = [near.start, near.end - 1].map(|k| row.pixels[k].0.into());
            let Some(ends) = within(t, reach, y, first, last) else { continue };
            for k in row.columns(ends) {
                let (x, behind) = row.pixels[k];
                if plane.nearest(x.into(), y) > self.shader.farther(behind, depth) {
                    self.found.push(Candidate { slot: row.start + k as u32, ..candidate });
                }
            }
        }
    }
}

/// The columns from `low` to `high` of row `y` whose pixels' centres have the triangle within `reach`, in x and in y: the
/// separating axes of the two are the square's sides, which are done with, and the edges' normals.
pub(super) fn within(t: &Triangle, reach: i64, y: i64, low: i64, high: i64) -> Option<(i64, i64)> {
    let subpixels = i64::from(SUBPIXELS);
    let way = |k: usize| [t.x[(k + 1) % 3] - t.x[k], t.y[(k + 1) % 3] - t.y[k]];
    let start = std::array::from_fn(|k| {
        let [dx, dy] = way(k);
        t.edge(k, low * subpixels + HALF, y * subpixels + HALF) + reach * (dx.abs() + dy.abs())
    });
    let step = std::array::from_fn(|k| -way(k)[1] * subpixels);
    span(start, step, high - low).map(|(from, to)| (low + from, low + to))
}

/// A triangle's stored depth, affine on the screen.
pub(super) struct Plane {
    /// At corner 0, and by sub-pixel in x and in y.
    origin: [i64; 2],
    depth: f64,
    slope: [f64; 2],
    /// The nearest of its corners.
    most: f64,
    reach: f64,
}

impl Plane {
    pub fn new(t: &Triangle, reach: i64) -> Self {
        let d = t.depth.map(f64::from);
        let [ux, uy, vx, vy] = [t.x[1] - t.x[0], t.y[1] - t.y[0], t.x[2] - t.x[0], t.y[2] - t.y[0]].map(|c| c as f64);
        let (du, dv) = (d[1] - d[0], d[2] - d[0]);
        Self {
            origin: [t.x[0], t.y[0]],
            depth: d[0],
            slope: [du * vy - dv * uy, dv * ux - du * vx].map(|s| s / t.area as f64),
            most: d[0].max(d[1]).max(d[2]),
            reach: reach as f64,
        }
    }

    /// The nearest depth of the triangle within reach of a pixel's centre, or more.
    pub fn nearest(&self, x: i64, y: i64) -> f64 {
        let subpixels = i64::from(SUBPIXELS);
        let [dx, dy] = [x * subpixels + HALF - self.origin[0], y * subpixels + HALF - self.origin[1]];
        let [sx, sy] = self.slope;
        let most = self.depth + sx * dx as f64 + sy * dy as f64 + (sx.abs() + sy.abs()) * self.reach;
        // Seen edge-on it has no slope.
        let most = if most < self.most { most } else { self.most };
        most + most.abs() * ROUNDING
    }
}
