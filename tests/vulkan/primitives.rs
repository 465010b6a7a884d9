//! Single triangles, strokes and conservative fragments against exact integers (i128), which share no code with any rasteriser.

use crate::{assert_silent, rasterizer};
use halfpixel::cuda::abi;
use halfpixel::stages::Fill;
use halfpixel::vulkan::{Input, Rasterizer};
use std::array::from_fn;

const SIZE: [u32; 2] = [48, 36];
/// Meshlets of one frame.
const TOGETHER: usize = 40;
const FOLD: u32 = abi::FOLD_INDEX;

/// A quad whose corners are (0, 0), (1, 0), (1, 1), (0, 1), in sub-pixels: two triangles along the first and third.
type Quad = [[i32; 2]; 4];

/// A xorshift generator: the same quads in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn within(&mut self, low: i32, high: i32) -> i32 {
        low + (self.next() % (i64::from(high) - i64::from(low) + 1) as u64) as i32
    }

    fn point(&mut self, reach: i32) -> [i32; 2] {
        SIZE.map(|n| self.within(-reach, n as i32 * 256 + reach))
    }
}

/// Random, and what rasterisers get wrong.
fn quads() -> Vec<Quad> {
    let mut r = Random(0x9e37_79b9_7f4a_7c15);
    let mut all = Vec::new();
    for k in 0..60 {
        // Of a few pixels, of all of the image, far beyond it, and beyond any viewport.
        for reach in [0, 2000, 1 << 20, 1 << 27] {
            all.push(from_fn(|_| r.point(reach)));
        }
        let a = r.point(0);
        let near = |r: &mut Random, by: i32| [a[0] + r.within(-by, by), a[1] + r.within(-by, by)];
        // Small, sub-pixel, slivers, points and lines.
        all.push(from_fn(|_| near(&mut r, 700)));
        all.push(from_fn(|_| near(&mut r, 90)));
        let b = r.point(500);
        all.push([a, b, [b[0] + 1, b[1] + k % 3 - 1], [a[0], a[1] + 1]]);
        all.push([a, b, a, b]);
        all.push([a; 4]);
        // Corners on pixel centres, edges along rows of them.
        let centre = |r: &mut Random| SIZE.map(|n| r.within(-2, n as i32 + 2) * 256 + 128);
        let [p, q] = [centre(&mut r), centre(&mut r)];
        all.push([p, [q[0], p[1]], q, [p[0], q[1]]]);
        all.push(from_fn(|_| centre(&mut r)));
        // Beside the image.
        all.push(from_fn(|_| [r.within(-90_000, -1), r.within(-5000, 9000)]));
        // Long and thin, across everything.
        let far = r.within(1 << 24, 1 << 28);
        all.push([[-far, b[1]], [far, a[1]], [far, a[1] + 3], [-far, b[1] + 3]]);
    }
    all
}

/// The lists of a frame: quads as patches of one quad each, the later the nearer.
struct Scene {
    quads: Vec<Quad>,
    patches: Vec<abi::Patch>,
    leaves: Vec<abi::Leaf>,
    meshlets: Vec<abi::Meshlet>,
    vertices: Vec<abi::Vertex>,
}

fn depth(k: usize) -> f32 {
    0.25 + 0.01 * k as f32
}

impl Scene {
    fn new(quads: &[Quad], diagonal: u8, hidden: i8, pen: i32) -> Self {
        let (mut meshlets, mut vertices) = (Vec::new(), Vec::new());
        for (k, quad) in quads.iter().enumerate() {
            meshlets.push(abi::Meshlet {
                patch: k as u32,
                vertices: vertices.len() as u32,
                quads: [1, 1],
                outer: 15,
                ..Default::default()
            });
            // v innermost.
            let grid = [quad[0], quad[3], quad[1], quad[2]];
            vertices.extend(grid.map(|[x, y]| abi::Vertex { x, y, depth: depth(k), weight: 1.0 }));
        }
        let leaf = abi::Leaf { pen_sides: [pen; 4], pen_radius: pen, ..Default::default() };
        let patch = abi::Patch { quads: [1, 1], degree: [1, 1], diagonal, hidden, ..Default::default() };
        Self {
            quads: quads.to_vec(),
            patches: vec![patch; quads.len()],
            leaves: vec![leaf; quads.len()],
            meshlets,
            vertices,
        }
    }

    fn draw(&self, rasterizer: &mut Rasterizer, fill: Fill) -> [Vec<u64>; 2] {
        let numbers: Vec<u32> = (0..self.meshlets.len() as u32).collect();
        let input = Input {
            size: SIZE,
            fill,
            patches: &self.patches,
            leaves: &self.leaves,
            meshlets: &self.meshlets,
            vertices: &self.vertices,
            numbers: &numbers,
            trims: None,
            alone: false,
        };
        let drawn = rasterizer.draw(&input).expect("a frame");
        [drawn.near.to_vec(), drawn.spare.to_vec()]
    }

    /// The two triangles of a quad, as its diagonal goes.
    fn triangles(&self, k: usize) -> [[[i128; 2]; 3]; 2] {
        let [p, q, r, s] = self.quads[k].map(|c| c.map(i128::from));
        if self.patches[k].diagonal == 0 { [[p, q, r], [p, r, s]] } else { [[p, q, s], [q, r, s]] }
    }
}

/// Twice the area of a, b, c: positive where they turn clockwise on the screen (y runs down).
fn turn(a: [i128; 2], b: [i128; 2], c: [i128; 2]) -> i128 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn clockwise([a, b, c]: [[i128; 2]; 3]) -> [[i128; 2]; 3] {
    if turn(a, b, c) < 0 { [a, c, b] } else { [a, b, c] }
}

/// The centre lies in the triangle, or on an edge that is its left or its top one.
fn covers(triangle: [[i128; 2]; 3], centre: [i128; 2]) -> bool {
    let t = clockwise(triangle);
    turn(t[0], t[1], t[2]) != 0
        && (0..3).all(|k| {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let owned = b[1] < a[1] || (b[1] == a[1] && b[0] > a[0]);
            turn(a, b, centre) > 0 || (turn(a, b, centre) == 0 && owned)
        })
}

/// The pixel's closed square and the closed triangle have a point in common: no line along a side of either parts them.
fn touches(triangle: [[i128; 2]; 3], centre: [i128; 2]) -> bool {
    let t = clockwise(triangle);
    let square = [[-128, -128], [128, -128], [128, 128], [-128, 128]].map(|d| from_fn(|k| centre[k] + d[k]));
    let edges = (0..3).all(|k| square.iter().any(|&corner| turn(t[k], t[(k + 1) % 3], corner) >= 0));
    let axes = (0..2).all(|k| {
        let (low, high) = (t.map(|c| c[k]).into_iter().min(), t.map(|c| c[k]).into_iter().max());
        low <= Some(centre[k] + 128) && high >= Some(centre[k] - 128)
    });
    edges && axes
}

/// A square pen of this radius along a side, over a centre on the outer side of the triangle behind it.
fn strokes([a, b, behind]: [[i128; 2]; 3], radius: i128, centre: [i128; 2]) -> bool {
    // Largest distance in x or y from the centre to the segment's line, times its length in that measure.
    let side = turn(a, b, centre);
    let reach = radius * ((b[0] - a[0]).abs() + (b[1] - a[1]).abs());
    let boxed = (0..2).all(|k| centre[k] >= a[k].min(b[k]) - radius && centre[k] <= a[k].max(b[k]) + radius);
    boxed && side.abs() <= reach && side.signum() * turn(a, b, behind).signum() <= 0
}

fn centres() -> impl Iterator<Item = (usize, [i128; 2])> {
    let [width, height] = SIZE.map(|n| n as usize);
    (0..width * height).map(move |k| (k, [(k % width) as i128 * 256 + 128, (k / width) as i128 * 256 + 128]))
}

fn low(word: u64) -> u32 {
    word as u32
}

/// The nearest quad with a triangle over each centre.
fn expect_near(scene: &Scene) -> Vec<Option<usize>> {
    let over = |centre| (0..scene.quads.len()).rev().find(|&k| (0..2).any(|n| is_over(scene, k, n, centre)));
    centres().map(|(_, centre)| over(centre)).collect()
}

/// A quad's triangle is drawn over a centre.
fn is_over(scene: &Scene, k: usize, n: usize, centre: [i128; 2]) -> bool {
    let triangle = scene.triangles(k)[n];
    let hidden = i128::from(scene.patches[k].hidden);
    covers(triangle, centre) && (hidden == 0 || turn(triangle[0], triangle[1], triangle[2]).signum() != hidden)
}

/// Which of a quad's triangles is nearer is a matter of rounding: all of it is equally deep.
fn assert_near(near: &[u64], expected: &[Option<usize>], scene: &Scene) {
    for ((pixel, centre), (&word, &expected)) in centres().zip(near.iter().zip(expected)) {
        let found = (word != 0).then(|| low(word) as usize >> 7);
        assert_eq!(found, expected, "pixel {pixel}: {:?}", expected.map(|k| scene.quads[k]));
        if let Some(k) = found {
            assert!(is_over(scene, k, low(word) as usize & 127, centre), "pixel {pixel}: {:?}", scene.quads[k]);
        }
    }
}

#[test]
fn triangles_cover_what_exact_integers_say() {
    let Some(mut rasterizer) = rasterizer() else { return };
    for (k, quads) in quads().chunks(TOGETHER).enumerate() {
        let hidden = [0, 1, -1][k % 3];
        let scene = Scene::new(quads, (k % 2) as u8, hidden, 1);
        let [near, spare] = scene.draw(&mut rasterizer, Fill::Off);
        assert_near(&near, &expect_near(&scene), &scene);
        assert!(spare.iter().all(|&word| word == 0));
        // A constant depth stays what it is, but for rounding.
        for &word in near.iter().filter(|&&word| word != 0) {
            let (found, given) = (f32::from_bits((word >> 32) as u32), depth(low(word) as usize >> 7));
            assert!((found - given).abs() <= 4e-7, "{found} {given}");
        }
    }
    assert_silent(&rasterizer);
}

#[test]
fn strokes_cover_what_exact_integers_say() {
    let Some(mut rasterizer) = rasterizer() else { return };
    for (k, quads) in quads().chunks(TOGETHER).enumerate() {
        let pen = [1, 77, 300, 20_000][k % 4];
        let scene = Scene::new(quads, (k % 2) as u8, 0, pen);
        let [near, spare] = scene.draw(&mut rasterizer, Fill::Stroke);
        let top = expect_near(&scene);
        assert_near(&near, &top, &scene);
        let behind = |k: usize, side: usize| {
            let [p, q, r, s] = scene.quads[k].map(|c| c.map(i128::from));
            let main = scene.patches[k].diagonal == 0;
            [
                [p, s, if main { r } else { q }],
                [q, r, if main { p } else { s }],
                [p, q, if main { r } else { s }],
                [s, r, if main { p } else { q }],
            ][side]
        };
        let expected: Vec<u32> = centres()
            .map(|(pixel, centre)| {
                // What lies behind the near triangle, or belongs to its own quad, is hidden.
                let first = top[pixel].map_or(0, |k| k + 1);
                let candidates = (first..scene.quads.len()).rev().flat_map(|k| (0..4).rev().map(move |side| (k, side)));
                let mut found = candidates.filter(|&(k, side)| strokes(behind(k, side), i128::from(pen), centre));
                found.next().map_or(0, |(k, side)| ((k as u32) << 7) | (98 + 7 * side as u32))
            })
            .collect();
        for (pixel, (&word, &expected)) in spare.iter().zip(&expected).enumerate() {
            assert_eq!(low(word), expected, "pixel {pixel}: {:?}", scene.quads.get(expected as usize >> 7));
        }
    }
    assert_silent(&rasterizer);
}

#[test]
fn conservative_fragments_are_those_that_touch() {
    let Some(mut rasterizer) = rasterizer() else { return };
    for (k, quads) in quads().chunks(TOGETHER).enumerate() {
        let scene = Scene::new(quads, (k % 2) as u8, 0, 1);
        let [near, spare] = scene.draw(&mut rasterizer, Fill::Conservative);
        let top = expect_near(&scene);
        assert_near(&near, &top, &scene);
        for (pixel, centre) in centres() {
            let first = top[pixel].map_or(0, |k| k + 1);
            let nearest = (first..scene.quads.len())
                .rev()
                .find(|&k| scene.triangles(k).iter().any(|&t| touches(t, centre) && !covers(t, centre)));
            let found = (spare[pixel] != 0).then(|| low(spare[pixel]) as usize >> 7);
            // The other triangle of the nearest quad may round to be nearer.
            let found = found.filter(|&k| Some(k) != top[pixel]);
            assert_eq!(found, nearest, "pixel {pixel}: {:?}", nearest.or(found).map(|k| scene.quads[k]));
            assert!(spare[pixel] == 0 || low(spare[pixel]) & 127 < 2);
        }
    }
    assert_silent(&rasterizer);
}

/// Along a fold of a two-quad grid: both sides of its edge, and nothing else of that kind.
#[test]
fn folds_are_drawn_where_the_sense_of_rotation_changes() {
    let Some(mut rasterizer) = rasterizer() else { return };
    let mut r = Random(77);
    for _ in 0..40 {
        let corners: [[i32; 2]; 6] = from_fn(|_| r.point(300));
        let pen = 200;
        let leaf = abi::Leaf { pen_fold: pen, pen_radius: 1, pen_sides: [1; 4], ..Default::default() };
        let patch = abi::Patch { quads: [2, 1], degree: [1, 1], ..Default::default() };
        let meshlet = abi::Meshlet { quads: [2, 1], ..Default::default() };
        let input = Input {
            size: SIZE,
            fill: Fill::Stroke,
            patches: &[patch],
            leaves: &[leaf],
            meshlets: &[meshlet],
            vertices: &corners.map(|[x, y]| abi::Vertex { x, y, depth: 0.5, weight: 1.0 }),
            numbers: &[0],
            trims: None,
            alone: false,
        };
        // (0,0) (0,1) (1,0) (1,1) (2,0) (2,1), cut from (i, j) to (i + 1, j + 1).
        let c = corners.map(|c| c.map(i128::from));
        let sign = |a: usize, b: usize, d: usize| turn(c[a], c[b], c[d]).signum();
        let signs = [sign(0, 2, 3), sign(0, 3, 1), sign(2, 4, 5), sign(2, 5, 3)];
        let edges = [(0, 3, signs[0] != signs[1]), (2, 5, signs[2] != signs[3]), (2, 3, signs[0] != signs[3])];
        let drawn = |centre| {
            edges.iter().any(|&(a, b, fold)| {
                // No triangle behind it: both sides.
                fold && strokes([c[a], c[b], c[a]], i128::from(pen), centre)
            })
        };
        let found = rasterizer.draw(&input).expect("a frame");
        let words = [found.near, found.spare];
        for (pixel, centre) in centres() {
            let hidden = words[0][pixel] != 0;
            let found = words[1][pixel] != 0;
            assert_eq!(found, drawn(centre) && !hidden, "pixel {pixel}: {corners:?}");
            assert!(!found || low(words[1][pixel]) == FOLD);
        }
    }
    assert_silent(&rasterizer);
}

/// More meshlets than one row of workgroups has.
#[test]
fn many_meshlets_are_all_drawn() {
    let Some(mut rasterizer) = rasterizer() else { return };
    let count = 66_000;
    let mut quads = vec![[[-1000, -1000], [-999, -1000], [-999, -999], [-1000, -999]]; count];
    for (k, x) in [(0, 0), (65_534, 1), (65_535, 2), (65_536, 3), (count - 1, 4)] {
        quads[k] = [[0, 0], [256, 0], [256, 256], [0, 256]].map(|[dx, dy]| [256 * x + dx, dy]);
    }
    let mut scene = Scene::new(&quads, 0, 0, 1);
    scene.vertices.iter_mut().for_each(|v| v.depth = 0.5);
    let [near, _] = scene.draw(&mut rasterizer, Fill::Off);
    let found: Vec<u32> = near[..6].iter().map(|&word| low(word) >> 7).collect();
    assert_eq!(found, [0, 65_534, 65_535, 65_536, count as u32 - 1, 0]);
    assert!(near[..5].iter().all(|&word| word != 0) && near[5] == 0);
    assert_silent(&rasterizer);
}
