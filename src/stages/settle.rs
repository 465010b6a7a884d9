//! Part of shade: which of the filled pixels were gaps, now that the exact surface is asked (DESIGN section 4,
//! "Refinement").
//!
//! A gap between two grids is no gap of the surface: some patch lies exactly under its pixel's centre. A stroke that
//! sticks out past the outline of a surface has none there.

use super::evaluate::{SUBPIXELS, Vertex};
use super::fill::Filled;
use super::frame::Targets;
use super::interpolate::{corner_parameters, interpolate};
use super::newton::{Batch, LANES};
use super::shade::Shader;
use super::topology::{depth_of, triangle_index, triangles, with_depth, word};
use super::trim_cut::{self, Cut, keeps};
use rayon::prelude::*;

/// Pixels between a pixel centre and a projected surface point that count as none.
pub(super) const EXACT: f32 = 1.0 / 128.0;
/// What the contract allows a filled pixel.
const HALF_PIXEL: f32 = 0.5;
/// Half a pixel in sub-pixels.
const HALF: i64 = SUBPIXELS as i64 / 2;
/// Rows of pixels that share a list of leaves.
const STRIP: u32 = 8;

/// A surface point under a pixel's centre.
struct Hit {
    /// Stored depth.
    depth: f32,
    /// Its triangle, as the lower half of a visibility word.
    triangle: u64,
    /// Leaf parameters.
    parameters: [f32; 2],
}

impl Hit {
    /// As a visibility word.
    fn word(&self) -> u64 {
        with_depth(self.triangle, self.depth)
    }
}

/// Strokes: a pixel goes to the nearest surface exactly under its centre, where that is nearer than what N shows; else
/// back to N.
pub(super) fn settle(shader: &Shader, targets: &mut Targets, filled: &mut Vec<Filled>) {
    let strips = Strips::new(shader, filled);
    let hits: Vec<Option<Hit>> = filled.par_iter().map(|f| nearest_hit(shader, &strips, f, true)).collect();
    let mut hits = hits.into_iter();
    filled.retain_mut(|f| {
        let hit = hits.next().flatten();
        targets.near[f.pixel as usize] = hit.as_ref().map_or(f.near, Hit::word);
        f.start = hit.map(|hit| hit.parameters);
        f.start.is_some()
    });
}

/// Pixels whose exact point is not where the depth test took it to be, each with its exact depth in `near`: another
/// surface that is nearer under the centre takes them; else the exact depth stands. Those taken join `filled`. A surface is
/// shown already, so that no gap is to be closed here.
pub(super) fn resettle(shader: &Shader, targets: &mut Targets, doubts: &[Filled], filled: &mut Vec<Filled>) {
    if doubts.is_empty() {
        return;
    }
    let strips = Strips::new(shader, doubts);
    let hits: Vec<Option<Hit>> = doubts.par_iter().map(|f| nearest_hit(shader, &strips, f, false)).collect();
    for (f, hit) in doubts.iter().zip(hits) {
        targets.near[f.pixel as usize] = hit.as_ref().map_or(f.near, Hit::word);
        filled.extend(hit.map(|hit| Filled { start: Some(hit.parameters), ..*f }));
    }
    filled.sort_unstable_by_key(|f| f.pixel);
}

/// Other ways to fill: what refinement leaves beyond half a pixel goes back to N.
pub(super) fn refuse(shader: &Shader, targets: &mut Targets, filled: &mut Vec<Filled>) {
    let stays = |f: &Filled| shader.surfel(targets.near[f.pixel as usize], f).residual <= HALF_PIXEL;
    let stays: Vec<bool> = filled.par_iter().map(stays).collect();
    let mut stays = stays.into_iter();
    filled.retain(|f| {
        let stays = stays.next() == Some(true);
        if !stays {
            targets.near[f.pixel as usize] = f.near;
        }
        stays
    });
}

/// `reaching`: faces reach over the model's gaps; else only what lies under the centre itself counts.
fn nearest_hit(shader: &Shader, strips: &Strips, f: &Filled, reaching: bool) -> Option<Hit> {
    // N's own surface lies within the depth tolerance of its depth: only what is clearly nearer counts.
    let behind = shader.nearer_by_tolerance(depth_of(f.near));
    let leaves = strips.leaves(shader, f.pixel, behind);
    let hits = leaves.filter_map(|leaf| search(shader, leaf, f, behind, reaching));
    // Equal depths go to the larger word, as everywhere.
    hits.max_by(|a, b| a.depth.total_cmp(&b.depth).then(a.triangle.cmp(&b.triangle)))
}

/// The leaf's surface exactly under a pixel's centre that is nearest to the eye, and nearer than `behind`.
///
/// The grid is within half a pixel of the surface, parameter by parameter: whatever lies under the centre has its
/// triangle that near, and refinement from that triangle finds it.
fn search(shader: &Shader, number: u32, f: &Filled, behind: f32, reaching: bool) -> Option<Hit> {
    let pixel = f.pixel;
    let mut surface = shader.surface(number);
    surface.any_sheet = true;
    let leaf = &shader.leaves[number as usize];
    let cut = Cut::new(shader.scene, shader.lens, shader.options, leaf);
    // Where the patch ends within the model's gap, its border stands in for what lies in it.
    let [border, gap] = if reaching { trim_cut::gaps(shader.scene, shader.lens, leaf) } else { [0.0; 2] };
    let belongs = |batch: &Batch, k: usize| match &cut {
        Some(cut) if reaching => keeps(shader, number, cut, &surface, batch, k),
        Some(cut) => cut.tree.contains(cut.to_plane([batch.s[k], batch.t[k]].map(f64::from))),
        None => true,
    };
    let exact = (EXACT + border as f32).min(HALF_PIXEL);
    let quads = shader.grids[number as usize].quads;
    let [x, y] = shader.target(leaf, pixel);
    let width = shader.lens.size[0];
    // From the nearest point and from the corners: a triangle seen edge-on may hide a fold.
    let starts: Vec<([f32; 2], u64)> = triangles_near(shader, number, pixel, depth_of(f.near), gap)
        .into_iter()
        .flat_map(|word| {
            let nearest = interpolate(shader.meshlets, quads, word, pixel % width, pixel / width);
            let corners = corner_parameters(shader.meshlets, quads, word);
            [nearest, corners[0], corners[1], corners[2]].map(|start| (start, word))
        })
        .collect();
    let mut best: Option<Hit> = None;
    for starts in starts.chunks(LANES) {
        let mut batch = Batch { x: [x; LANES], y: [y; LANES], ..Batch::default() };
        for k in 0..LANES {
            [batch.s[k], batch.t[k]] = starts[k.min(starts.len() - 1)].0;
        }
        shader.refine(&surface, 1, &mut batch);
        for (k, &(_, triangle)) in starts.iter().enumerate().filter(|&(k, _)| batch.residual[k] <= exact) {
            let depth = shader.stored_depth(surface.depth_origin + batch.z[k]);
            let nearer = depth > behind && best.as_ref().is_none_or(|b| (depth, triangle) > (b.depth, b.triangle));
            if nearer && belongs(&batch, k) {
                best = Some(Hit { depth, triangle, parameters: [batch.s[k], batch.t[k]] });
            }
        }
    }
    best
}

/// The leaf's triangles that come within half a pixel of a pixel's centre, as words without depth.
///
/// The surface is within the depth tolerance of its triangle: triangles that are wholly behind what N shows have nothing
/// clearly nearer. `gap`: pixels more, which the model leaves open.
fn triangles_near(shader: &Shader, leaf: u32, pixel: u32, shown: f32, gap: f64) -> Vec<u64> {
    let reach = HALF + (gap * f64::from(SUBPIXELS)).ceil() as i64;
    let width = shader.lens.size[0];
    let center = [pixel % width, pixel / width].map(|c| (2 * i64::from(c) + 1) * HALF);
    let meshlets = &shader.meshlets.meshlets;
    let first = meshlets.partition_point(|m| m.leaf < leaf);
    let mut found = Vec::new();
    for (number, meshlet) in meshlets.iter().enumerate().skip(first).take_while(|(_, m)| m.leaf == leaf) {
        for (a, b) in
            (0..usize::from(meshlet.quads[0])).flat_map(|a| (0..usize::from(meshlet.quads[1])).map(move |b| (a, b)))
        {
            for (k, corners) in triangles(a, b, meshlet.diagonal).into_iter().enumerate() {
                let v = corners.map(|[i, j]| shader.meshlets.vertices[meshlet.vertex(i, j)]);
                if v.iter().any(|v| v.depth > shown) && touches(&v, center, reach) {
                    found.push(word(0.0, number as u32, triangle_index(meshlet, a, b) + k as u32));
                }
            }
        }
    }
    found
}

/// The triangle meets the square of half a pixel (and a gap) about a point: separating axes are the square's sides and the three
/// edges' normals.
fn touches(v: &[Vertex; 3], center: [i64; 2], reach: i64) -> bool {
    let apart = |a: i64, b: i64, c: i64, at: i64| a.min(b).min(c) > at + reach || a.max(b).max(c) < at - reach;
    let p = v.map(|v| [i64::from(v.x), i64::from(v.y)]);
    if (0..2).any(|k| apart(p[0][k], p[1][k], p[2][k], center[k])) {
        return false;
    }
    let (ux, uy, vx, vy) = (p[1][0] - p[0][0], p[1][1] - p[0][1], p[2][0] - p[0][0], p[2][1] - p[0][1]);
    let side = (ux * vy - uy * vx).signum();
    (0..3).all(|k| {
        let (a, b) = (p[k], p[(k + 1) % 3]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let e = side * (dx * (center[1] - a[1]) - dy * (center[0] - a[0]));
        e >= -reach * (dx.abs() + dy.abs())
    })
}

/// Leaves by strips of rows, for the strips that have filled pixels; boxes beside the numbers, since they are looked at
/// for every filled pixel.
struct Strips {
    lists: Vec<Vec<Entry>>,
}

/// A leaf's box in pixels about the image centre, and its nearest stored depth.
#[derive(Clone, Copy)]
struct Entry {
    leaf: u32,
    low: [f32; 2],
    high: [f32; 2],
    nearest: f32,
}

impl Strips {
    fn new(shader: &Shader, filled: &[Filled]) -> Self {
        let [width, height] = shader.lens.size;
        let mut wanted = vec![false; height.div_ceil(STRIP) as usize];
        for f in filled {
            wanted[(f.pixel / width / STRIP) as usize] = true;
        }
        let mut lists = vec![Vec::new(); wanted.len()];
        let half = shader.lens.half(1);
        for (k, leaf) in shader.leaves.iter().enumerate() {
            // A pixel to spare: boxes are rounded to f32.
            let spare = 1.0 + trim_cut::gaps(shader.scene, shader.lens, leaf)[1];
            let entry = Entry {
                leaf: k as u32,
                low: [0, 1].map(|k| (leaf.low[k] - spare) as f32),
                high: [0, 1].map(|k| (leaf.high[k] + spare) as f32),
                nearest: shader.stored_depth(leaf.low.z as f32),
            };
            let row =
                |y: f32| ((f64::from(y) + half) / f64::from(STRIP)).clamp(0.0, wanted.len() as f64 - 1.0) as usize;
            for strip in (row(entry.low[1])..=row(entry.high[1])).filter(|&s| wanted[s]) {
                lists[strip].push(entry);
            }
        }
        Self { lists }
    }

    /// Leaves whose box holds the pixel's centre and that have something nearer than `behind`.
    fn leaves<'a>(&'a self, shader: &Shader, pixel: u32, behind: f32) -> impl Iterator<Item = u32> + 'a {
        let width = shader.lens.size[0];
        let center = [pixel % width, pixel / width];
        let center: [f32; 2] = std::array::from_fn(|k| center[k] as f32 + 0.5 - shader.lens.half(k) as f32);
        let holds =
            move |e: &&Entry| e.nearest > behind && (0..2).all(|k| e.low[k] <= center[k] && center[k] <= e.high[k]);
        self.lists[(pixel / width / STRIP) as usize].iter().filter(holds).map(|e| e.leaf)
    }
}
