//! rasterize: triangles and border strokes into the two 64-bit buffers, band by band (DESIGN section 4).

use super::estimate::MESHLET;
use super::evaluate::{Meshlet, Meshlets, SUBPIXELS, Vertex};
use super::frame::Targets;
use super::stroke::{self, Pen};
use super::topology::{FOLD, edge, edge_index, triangle_index, triangles, word};
use super::{Fill, Options};
use rayon::prelude::*;

/// Rows of pixels one task draws: a band of both buffers stays in the second-level cache.
pub(super) const BAND: usize = 16;
const HALF: i64 = SUBPIXELS as i64 / 2;
/// Rows of so many pixels and more are worth three divisions to find what the triangle has of them.
const LONG: i64 = 12;

/// One band of both buffers.
pub(super) struct Band<'a> {
    pub width: i32,
    /// First row and one past the last.
    pub rows: [i32; 2],
    /// Centre-covered fragments (N).
    pub near: &'a mut [u64],
    /// What may close a crack (S). Zero but for the pixels in `touched`.
    pub spare: &'a mut [u64],
    /// Pixels of the band that `spare` has.
    pub touched: &'a mut Vec<u32>,
    /// Where it stands, fragments for `spare` are listed there instead: pixel of the band, word.
    pub listed: Option<Vec<(u32, u64)>>,
}

/// Draws the meshlets that are named, but for those that trim.rs tests. `pens[leaf]` is the stroke radius of a leaf.
pub(super) fn rasterize(
    meshlets: &Meshlets,
    numbers: impl Iterator<Item = u32> + Clone,
    pens: &[Pen],
    options: &Options,
    size: [u32; 2],
    targets: &mut Targets,
) {
    let width = size[0] as usize;
    let bins = Bins::new(&meshlets.meshlets, numbers, (size[1] as usize).div_ceil(BAND));
    let bands = targets
        .near
        .par_chunks_mut(width * BAND)
        .zip(targets.spare.par_chunks_mut(width * BAND))
        .zip(targets.touched.par_iter_mut())
        .enumerate();
    bands.for_each(|(k, ((near, spare), touched))| {
        // What the last frame left: all of N, and the few pixels of S that strokes touched.
        near.fill(0);
        touched.drain(..).for_each(|p| spare[p as usize] = 0);
        let first = (k * BAND) as i32;
        let rows = [first, first + (near.len() / width) as i32];
        let mut band = Band { width: width as i32, rows, near, spare, touched, listed: None };
        for &number in bins.of(k) {
            draw(meshlets, number, pens, options, &mut band);
        }
    });
}

/// Lists of meshlets, band after band, each in meshlet order.
pub(super) struct Bins {
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

impl Bins {
    /// A counting sort of some meshlets by the bands that their rows touch; in each band they keep their order.
    pub fn new(meshlets: &[Meshlet], numbers: impl Iterator<Item = u32> + Clone, bands: usize) -> Self {
        let range = |k: u32| {
            let [low, high] = meshlets[k as usize].rows.map(usize::from);
            if low < high { low / BAND..(high - 1) / BAND + 1 } else { 0..0 }
        };
        let mut starts = vec![0u32; bands + 1];
        for k in numbers.clone() {
            range(k).for_each(|b| starts[b + 1] += 1);
        }
        for b in 0..bands {
            starts[b + 1] += starts[b];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0u32; starts[bands] as usize];
        for k in numbers {
            for b in range(k) {
                sorted[next[b] as usize] = k;
                next[b] += 1;
            }
        }
        Self { starts, numbers: sorted }
    }

    pub fn of(&self, band: usize) -> &[u32] {
        &self.numbers[self.starts[band] as usize..self.starts[band + 1] as usize]
    }
}

/// One meshlet into one band.
fn draw(meshlets: &Meshlets, number: u32, pens: &[Pen], options: &Options, band: &mut Band) {
    let meshlet = &meshlets.meshlets[number as usize];
    if meshlet.tested {
        return;
    }
    let at = |[i, j]: [usize; 2]| meshlets.vertices[meshlet.vertex(i, j)];
    for a in 0..usize::from(meshlet.quads[0]) {
        for b in 0..usize::from(meshlet.quads[1]) {
            let first = triangle_index(meshlet, a, b);
            for (k, corners) in triangles(a, b, meshlet.diagonal).into_iter().enumerate() {
                let corners = corners.map(at);
                if !faces_away(&corners, meshlet.hidden)
                    && let Some(coverage) = Coverage::new(&corners, band)
                {
                    coverage.draw(coverage.pixels, word(0.0, number, first + k as u32), band);
                }
            }
        }
    }
    outlines(meshlets, number, pens, options.fill, band);
}

/// A meshlet's fragments for the spare buffer.
pub(super) fn outlines(meshlets: &Meshlets, number: u32, pens: &[Pen], fill: Fill, band: &mut Band) {
    let meshlet = &meshlets.meshlets[number as usize];
    let at = |[i, j]: [usize; 2]| meshlets.vertices[meshlet.vertex(i, j)];
    let [across_u, across_v] = meshlet.quads.map(usize::from);
    if matches!(fill, Fill::Eter | Fill::Conservative) {
        for (a, b) in (0..across_u).flat_map(|a| (0..across_v).map(move |b| (a, b))) {
            let first = triangle_index(meshlet, a, b);
            for (k, corners) in triangles(a, b, meshlet.diagonal).into_iter().enumerate() {
                stroke::conservative(&corners.map(at), word(0.0, number, first + k as u32), band);
            }
        }
    }
    if fill != Fill::Stroke {
        return;
    }
    let pen = &pens[meshlet.leaf as usize];
    if pen.fold > 0 {
        folds(meshlets, number, pen, band);
        turned_away(meshlets, number, pen, band);
    }
    for side in (0..4).filter(|side| meshlet.outer >> side & 1 == 1) {
        for k in 0..if side < 2 { across_v } else { across_u } {
            let corners = edge(meshlet, side, k).map(at);
            // Edges of sides u = 0 and v = 1 come against the parameters' order.
            let hidden = if matches!(side, 0 | 3) { -meshlet.hidden } else { meshlet.hidden };
            // The surface behind an edge that may fold is seen from both sides.
            if faces_away(&corners, hidden) && !pen.may_fold(&corners) {
                continue;
            }
            stroke::stroke(&corners, side, pen, word(0.0, number, edge_index(side, k)), band);
        }
    }
}

/// Strokes along the grid's silhouette: edges between a triangle that faces the eye and one that does not.
fn folds(meshlets: &Meshlets, number: u32, pen: &Pen, band: &mut Band) {
    let meshlet = &meshlets.meshlets[number as usize];
    let at = |[i, j]: [usize; 2]| meshlets.vertices[meshlet.vertex(i, j)];
    let [across_u, across_v] = meshlet.quads.map(usize::from);
    let id = word(0.0, number, FOLD);
    let mut stroke = |a: [usize; 2], b: [usize; 2]| stroke::fold(&at(a), &at(b), pen, id, band);
    let [next_u, next_v] = next_blocks(&meshlets.meshlets, number as usize);
    let main = meshlet.diagonal == 0;
    let mut own = [[0; 2]; (MESHLET * MESHLET) as usize];
    for (k, own) in own[..across_u * across_v].iter_mut().enumerate() {
        *own = facings(meshlets, meshlet, k / across_v, k % across_v);
    }
    let facing = |m: &Meshlet, a: usize, b: usize| {
        if std::ptr::eq(m, meshlet) { own[a * across_v + b] } else { facings(meshlets, m, a, b) }
    };
    // The triangle on side v = 1 is always the second, on v = 0 the first; u = 1 and u = 0 go by the diagonal.
    let (right, left) = if main { (0, 1) } else { (1, 0) };
    for a in 0..across_u {
        for b in 0..across_v {
            let here = own[a * across_v + b];
            if here[0] != here[1] {
                if main { stroke([a, b], [a + 1, b + 1]) } else { stroke([a + 1, b], [a, b + 1]) }
            }
            let above = if b + 1 < across_v { Some((meshlet, b + 1)) } else { next_v.map(|m| (m, 0)) };
            if above.is_some_and(|(m, b)| here[1] != facing(m, a, b)[0]) {
                stroke([a, b + 1], [a + 1, b + 1]);
            }
            let beyond = if a + 1 < across_u { Some((meshlet, a + 1)) } else { next_u.map(|m| (m, 0)) };
            if beyond.is_some_and(|(m, a)| here[right] != facing(m, a, b)[left]) {
                stroke([a + 1, b], [a + 1, b + 1]);
            }
        }
    }
}

/// Triangles that show the inside of a solid, where the surface may fold and show its outside.
fn turned_away(meshlets: &Meshlets, number: u32, pen: &Pen, band: &mut Band) {
    let meshlet = &meshlets.meshlets[number as usize];
    if meshlet.hidden == 0 {
        return;
    }
    let [across_u, across_v] = meshlet.quads.map(usize::from);
    for (a, b) in (0..across_u).flat_map(|a| (0..across_v).map(move |b| (a, b))) {
        for corners in triangles(a, b, meshlet.diagonal) {
            let corners = corners.map(|[i, j]| meshlets.vertices[meshlet.vertex(i, j)]);
            if faces_away(&corners, meshlet.hidden) && pen.may_fold(&corners) {
                stroke::turned_away(&corners, word(0.0, number, FOLD), band);
            }
        }
    }
}

/// Signs of the screen areas of a quad's two triangles, in parameter order.
fn facings(meshlets: &Meshlets, meshlet: &Meshlet, a: usize, b: usize) -> [i64; 2] {
    triangles(a, b, meshlet.diagonal).map(|corners| {
        let [a, b, c] = corners.map(|[i, j]| meshlets.vertices[meshlet.vertex(i, j)]);
        let (ux, uy) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
        let (vx, vy) = (i64::from(c.x) - i64::from(a.x), i64::from(c.y) - i64::from(a.y));
        (ux * vy - uy * vx).signum()
    })
}

/// The blocks of the same leaf that follow a meshlet in u and in v. Blocks come in parameter order, v innermost.
fn next_blocks(meshlets: &[Meshlet], number: usize) -> [Option<&Meshlet>; 2] {
    let here = &meshlets[number];
    let [u, v] = here.first;
    let mut later = meshlets[number + 1..].iter().take_while(|m| m.leaf == here.leaf);
    let inner = |side: u8| here.outer >> side & 1 == 0;
    let below =
        meshlets.get(number + 1).filter(|m| m.leaf == here.leaf && m.first == [u, v + u16::from(here.quads[1])]);
    let next_v = below.filter(|_| inner(3));
    let next_u = if inner(1) { later.find(|m| m.first == [u + u16::from(here.quads[0]), v]) } else { None };
    [next_u, next_v]
}

/// The triangle shows the inside of a solid. Each point of the image that the solid covers is covered by a triangle
/// that faces the eye, so that leaving these out opens nothing.
pub(super) fn faces_away([a, b, c]: &[Vertex; 3], hidden: i8) -> bool {
    if hidden == 0 {
        return false;
    }
    let (ux, uy) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
    let (vx, vy) = (i64::from(c.x) - i64::from(a.x), i64::from(c.y) - i64::from(a.y));
    (ux * vy - uy * vx).signum() == i64::from(hidden)
}

/// Three corners turned so that the area is positive, with their edge functions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub x: [i64; 3],
    pub y: [i64; 3],
    pub depth: [f32; 3],
    /// Twice the area in square sub-pixels.
    pub area: i64,
}

impl Triangle {
    pub fn new(corners: &[Vertex; 3]) -> Self {
        let mut c = *corners;
        let area = |c: &[Vertex; 3]| {
            let [a, b, d] = c.map(|v| (i64::from(v.x), i64::from(v.y)));
            (b.0 - a.0) * (d.1 - a.1) - (d.0 - a.0) * (b.1 - a.1)
        };
        if area(&c) < 0 {
            c.swap(1, 2);
        }
        Self { x: c.map(|v| i64::from(v.x)), y: c.map(|v| i64::from(v.y)), depth: c.map(|v| v.depth), area: area(&c) }
    }

    /// Edge function of corner k to the next at a point: positive inside.
    pub fn edge(&self, k: usize, px: i64, py: i64) -> i64 {
        let n = (k + 1) % 3;
        (self.x[n] - self.x[k]) * (py - self.y[k]) - (self.y[n] - self.y[k]) * (px - self.x[k])
    }

    /// Points on edge k belong to this triangle: the top-left rule, y down.
    pub fn owns(&self, k: usize) -> bool {
        let n = (k + 1) % 3;
        let (dx, dy) = (self.x[n] - self.x[k], self.y[n] - self.y[k]);
        dy < 0 || (dy == 0 && dx > 0)
    }
}

/// Pixels whose centres lie within [low, high] sub-pixels: first and last.
pub(super) fn pixel_range(low: i64, high: i64) -> (i64, i64) {
    ((low - HALF + SUBPIXELS as i64 - 1).div_euclid(SUBPIXELS as i64), (high - HALF).div_euclid(SUBPIXELS as i64))
}

/// The first and last of `0..=steps` at which three edge functions are all at least zero, each `start + step k` there.
pub(super) fn span(start: [i64; 3], step: [i64; 3], steps: i64) -> Option<(i64, i64)> {
    let (mut low, mut high) = (0, steps);
    for (e, d) in start.into_iter().zip(step) {
        match d.signum() {
            1 if e < 0 => low = low.max((d - 1 - e) / d),
            -1 if e >= 0 => high = high.min(e / -d),
            _ if e < 0 => return None,
            _ => {}
        }
    }
    (low <= high).then_some((low, high))
}

/// The pixel centres that a triangle covers in one band.
pub(super) struct Coverage {
    /// First and last pixel in x and in y that it may cover.
    pub pixels: [(i64, i64); 2],
    triangle: Triangle,
    /// 1 for edges whose points the top-left rule gives away.
    bias: [i64; 3],
    /// Stored depth of the corner opposite to each edge, over the area.
    depth: [f32; 3],
}

impl Coverage {
    /// `None` where the triangle covers nothing; most small ones hold no pixel centre at all.
    pub fn new(corners: &[Vertex; 3], band: &Band) -> Option<Self> {
        let [a, b, c] = corners;
        let (x0, x1) = pixel_range(i64::from(a.x.min(b.x).min(c.x)), i64::from(a.x.max(b.x).max(c.x)));
        let (y0, y1) = pixel_range(i64::from(a.y.min(b.y).min(c.y)), i64::from(a.y.max(b.y).max(c.y)));
        let (x0, x1) = (x0.max(0), x1.min(i64::from(band.width) - 1));
        let (y0, y1) = (y0.max(i64::from(band.rows[0])), y1.min(i64::from(band.rows[1]) - 1));
        if x0 > x1 || y0 > y1 {
            return None;
        }
        let t = Triangle::new(corners);
        let inverse = 1.0 / t.area as f32;
        let depth = [t.depth[2], t.depth[0], t.depth[1]].map(|d| d * inverse);
        let bias = std::array::from_fn(|k| i64::from(!t.owns(k)));
        (t.area != 0).then_some(Self { pixels: [(x0, x1), (y0, y1)], triangle: t, bias, depth })
    }

    /// The triangle may cover centres in a part of `pixels`: no edge has all of them on its outer side.
    pub fn meets(&self, [(x0, x1), (y0, y1)]: [(i64, i64); 2]) -> bool {
        let t = &self.triangle;
        let center = |pixel: i64| pixel * SUBPIXELS as i64 + HALF;
        (0..3).all(|k| {
            let n = (k + 1) % 3;
            let x = if t.y[n] > t.y[k] { x0 } else { x1 };
            let y = if t.x[n] > t.x[k] { y1 } else { y0 };
            t.edge(k, center(x), center(y)) >= self.bias[k]
        })
    }

    /// Some pixel, x and y, in a part of `pixels` that the triangle covers.
    pub fn first(&self, [(x0, x1), (y0, y1)]: [(i64, i64); 2]) -> Option<[i64; 2]> {
        let t = &self.triangle;
        let subpixels = SUBPIXELS as i64;
        let step = std::array::from_fn(|k| -(t.y[(k + 1) % 3] - t.y[k]) * subpixels);
        (y0..=y1).find_map(|y| {
            let start = |k: usize| t.edge(k, x0 * subpixels + HALF, y * subpixels + HALF) - self.bias[k];
            span(std::array::from_fn(start), step, x1 - x0).map(|(from, _)| [x0 + from, y])
        })
    }

    /// Some fragment would win.
    pub fn wins(&self, id: u64, band: &mut Band) -> bool {
        let mut wins = false;
        self.until(self.pixels, id, band, |_, _, _| {
            wins = true;
            wins
        });
        wins
    }

    /// Fragments in a part of `pixels`.
    #[inline(always)]
    pub fn draw(&self, part: [(i64, i64); 2], id: u64, band: &mut Band) {
        self.each(part, id, band, |near, _, fragment| *near = fragment);
    }

    /// Calls `found` with every fragment in a part of `pixels` that would win: its place in the near buffer, its column and its
    /// row in the band, its word.
    #[inline(always)]
    pub fn each(
        &self,
        part: [(i64, i64); 2],
        id: u64,
        band: &mut Band,
        mut found: impl FnMut(&mut u64, [u32; 2], u64),
    ) {
        self.until(part, id, band, |near, place, fragment| {
            found(near, place, fragment);
            false
        });
    }

    /// The same until it returns true.
    #[inline(always)]
    fn until(
        &self,
        [(x0, x1), (y0, y1)]: [(i64, i64); 2],
        id: u64,
        band: &mut Band,
        mut found: impl FnMut(&mut u64, [u32; 2], u64) -> bool,
    ) {
        let t = &self.triangle;
        // Points on an edge that the top-left rule gives away are outside by one.
        let (px, py) = (x0 * SUBPIXELS as i64 + HALF, y0 * SUBPIXELS as i64 + HALF);
        let start: [i64; 3] = std::array::from_fn(|k| t.edge(k, px, py) - self.bias[k]);
        let step_x: [i64; 3] = std::array::from_fn(|k| -(t.y[(k + 1) % 3] - t.y[k]) * SUBPIXELS as i64);
        let step_y: [i64; 3] = std::array::from_fn(|k| (t.x[(k + 1) % 3] - t.x[k]) * SUBPIXELS as i64);
        for y in y0..=y1 {
            let row_number = (y - i64::from(band.rows[0])) as u32;
            let row = &mut band.near[row_number as usize * band.width as usize..][..band.width as usize];
            let dy = y - y0;
            let mut e: [i64; 3] = std::array::from_fn(|k| start[k] + step_y[k] * dy);
            let (mut first_x, mut last_x) = (x0, x1);
            if x1 - x0 >= LONG {
                let Some((from, to)) = span(e, step_x, x1 - x0) else { continue };
                (first_x, last_x) = (x0 + from, x0 + to);
                e = std::array::from_fn(|k| e[k] + step_x[k] * from);
            }
            for (x, pixel) in (first_x..).zip(&mut row[first_x as usize..=last_x as usize]) {
                if (e[0] | e[1] | e[2]) >= 0 {
                    let weight = |k: usize| (e[k] + self.bias[k]) as f32;
                    let d = weight(0) * self.depth[0] + weight(1) * self.depth[1] + weight(2) * self.depth[2];
                    let fragment = id | u64::from(d.to_bits()) << 32;
                    if fragment > *pixel && found(pixel, [x as u32, row_number], fragment) {
                        return;
                    }
                }
                for k in 0..3 {
                    e[k] += step_x[k];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spans_are_what_all_edges_leave(
            start in prop::array::uniform3(-500i64..500),
            step in prop::array::uniform3(-40i64..40),
            steps in 0i64..60,
        ) {
            let inside = |k: &i64| (0..3).all(|n| start[n] + step[n] * k >= 0);
            let all: Vec<i64> = (0..=steps).filter(inside).collect();
            let ends = all.first().copied().zip(all.last().copied());
            prop_assert_eq!(span(start, step, steps), ends);
        }
    }
}
