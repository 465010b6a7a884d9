//! The stages against definitions written anew: exact integers, brute force, dense sampling.

mod cull;
mod deviation;
mod grid;
mod limits;
mod near;
mod newton;
mod raster;
mod routes;
mod sharing;
mod strokes;
mod textures;
mod words;

use super::evaluate::{Meshlet, Meshlets, Vertex};
use super::frame::Targets;
use super::rasterize::{BAND, rasterize};
use super::stroke::Pen;
use super::{Fill, Options};

/// SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In `0..count`.
    fn below(&mut self, count: u64) -> u64 {
        self.bits() % count
    }

    /// In [low, high).
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A sub-pixel coordinate in [low, high) pixels; every other one is a pixel centre or border.
    fn coordinate(&mut self, low: i32, high: i32) -> i32 {
        let any = low * 256 + self.below((high - low) as u64 * 256) as i32;
        if self.below(2) == 0 { any } else { any / 128 * 128 }
    }

    fn vertex(&mut self, low: i32, high: i32) -> Vertex {
        let (x, y) = (self.coordinate(low, high), self.coordinate(low, high));
        Vertex { x, y, depth: self.between(0.1, 1.0) as f32, weight: 1.0 }
    }
}

/// A meshlet of one quad whose first triangle is `corners`, whose second has no area, and whose only outer edge runs
/// from the first corner to the second.
fn single([a, b, c]: [Vertex; 3], height: u32) -> Meshlets {
    let meshlet = Meshlet {
        leaf: 0,
        vertices: 0,
        first: [0, 0],
        quads: [1, 1],
        hidden: 0,
        diagonal: 0,
        tested: false,
        outer: 0b0100,
        columns: [0, u16::MAX],
        rows: [0, height as u16],
    };
    // Corners (0,0), (0,1), (1,0), (1,1).
    Meshlets { meshlets: vec![meshlet], vertices: vec![a, a, b, c], quads: 1, ..Meshlets::default() }
}

/// Both buffers of a picture of one triangle.
fn draw(corners: [Vertex; 3], pen: Pen, fill: Fill, size: [u32; 2]) -> Targets {
    let pixels = (size[0] * size[1]) as usize;
    let mut targets = Targets {
        near: vec![0; pixels],
        spare: vec![0; pixels],
        touched: vec![Vec::new(); (size[1] as usize).div_ceil(BAND)],
        ..Targets::default()
    };
    let options = Options { fill, ..Options::default() };
    rasterize(&single(corners, size[1]), 0..1, &[pen], &options, size, &mut targets);
    targets
}

/// Pixel centres of a picture, row by row, in sub-pixels.
fn centers(size: [u32; 2]) -> impl Iterator<Item = [i128; 2]> {
    let at = |p: u32| i128::from(p) * 256 + 128;
    (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [at(x), at(y)]))
}

fn place(v: &Vertex) -> [i128; 2] {
    [v.x.into(), v.y.into()]
}

/// Twice the signed area of a, b, c.
fn area([ax, ay]: [i128; 2], [bx, by]: [i128; 2], [cx, cy]: [i128; 2]) -> i128 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}
