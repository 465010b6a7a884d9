//! fill: where a spare fragment closes a crack, it takes the pixel (DESIGN section 4; ETER's CRK).

use super::evaluate::Meshlets;
use super::frame::Targets;
use super::rasterize::BAND;
use super::stroke::is_nearer;
use super::topology::{Primitive, depth_of, index_of, meshlet_of, primitive};
use super::{Fill, Options};
use rayon::prelude::*;

/// Entries of the 3x3 neighbourhood that may show what N shows here for the vote to fill.
const VOTE: usize = 3;
/// Cosine beyond which a neighbour counts as outward of a stroke.
const OUTWARD: f32 = 0.3;

/// A pixel that the spare buffer took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filled {
    pub pixel: u32,
    /// What the near buffer had: shading may give the pixel back.
    pub near: u64,
    /// Leaf parameters from which to refine, where shading has found them; else those of the word.
    pub start: Option<[f32; 2]>,
}

/// Decides every touched pixel from the near buffer alone, then writes; returns the pixels taken, in image order.
pub(super) fn fill(meshlets: &Meshlets, options: &Options, size: [u32; 2], targets: &mut Targets) -> Vec<Filled> {
    let width = size[0] as usize;
    let exact = options.refine > 0;
    let rule = Rule { meshlets, near: &targets.near, size: size.map(|s| s as i32) };
    let mut taken: Vec<(Filled, u64)> = (targets.touched.par_iter().enumerate())
        .flat_map_iter(|(band, touched)| {
            let first = (band * BAND * width) as u32;
            let (rule, spare, near) = (&rule, &targets.spare, &targets.near);
            touched.iter().filter_map(move |&p| {
                let pixel = first + p;
                let (s, n) = (spare[pixel as usize], near[pixel as usize]);
                let wanted = is_nearer(s, n)
                    && match options.fill {
                        // Shading asks the exact surface (settle.rs); without it the neighbours have to tell.
                        Fill::Stroke => exact || rule.continues(pixel, s, n) || rule.vote(pixel, n),
                        Fill::Eter => rule.leaf(s) != rule.leaf(n) && rule.vote(pixel, n),
                        Fill::Conservative => true,
                        Fill::Off => false,
                    };
                wanted.then_some((Filled { pixel, near: n, start: None }, s))
            })
        })
        .collect();
    taken.sort_unstable_by_key(|(filled, _)| filled.pixel);
    for (filled, spare) in &taken {
        targets.near[filled.pixel as usize] = *spare;
    }
    taken.into_iter().map(|(filled, _)| filled).collect()
}

/// Spare fragments may stay as they are, so that trims are asked about them at their own parameters.
pub(super) fn is_tested_alone(options: &Options) -> bool {
    options.refine == 0 || options.fill != Fill::Stroke
}

struct Rule<'a> {
    meshlets: &'a Meshlets,
    near: &'a [u64],
    size: [i32; 2],
}

impl Rule<'_> {
    /// The piece of surface a word shows: instance, patch and corner; `None` for background. Pieces that splitting
    /// made are patches like any other.
    fn leaf(&self, word: u64) -> Option<u32> {
        (word != 0).then(|| self.meshlets.meshlets[meshlet_of(word) as usize].leaf)
    }

    fn neighbours(&self, pixel: u32) -> impl Iterator<Item = (i32, i32, u64)> + '_ {
        let [width, height] = self.size;
        let (x, y) = (pixel as i32 % width, pixel as i32 / width);
        (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (dx, dy))).filter_map(move |(dx, dy)| {
            let (qx, qy) = (x + dx, y + dy);
            let inside = (0..width).contains(&qx) && (0..height).contains(&qy);
            inside.then(|| (dx, dy, self.near[(qy * width + qx) as usize]))
        })
    }

    /// Rule 5a: some neighbour outward of the stroke continues the surface: it is nearer than the midpoint of what
    /// the stroke shows and what lies behind it.
    fn continues(&self, pixel: u32, spare: u64, near: u64) -> bool {
        let middle = (depth_of(spare) + depth_of(near)) * 0.5;
        let normal = self.outward(spare);
        self.neighbours(pixel).any(|(dx, dy, word)| {
            let towards = normal.is_none_or(|[nx, ny]| dx as f32 * nx + dy as f32 * ny > OUTWARD);
            (dx, dy) != (0, 0) && towards && depth_of(word) > middle
        })
    }

    /// Rule 5b and ETER section 6.1: few of the nine pixels show what N shows here. Background counts as a patch.
    fn vote(&self, pixel: u32, near: u64) -> bool {
        let here = self.leaf(near);
        self.neighbours(pixel).filter(|&(_, _, word)| self.leaf(word) == here).count() <= VOTE
    }

    /// Unit normal of a stroke's edge on the screen, away from its triangle; `None` where it has none.
    fn outward(&self, spare: u64) -> Option<[f32; 2]> {
        let meshlet = &self.meshlets.meshlets[meshlet_of(spare) as usize];
        let Primitive::Edge(corners) = primitive(meshlet, index_of(spare)) else { return None };
        let [a, b, c] = corners.map(|[i, j]| self.meshlets.vertices[meshlet.vertex(i, j)]);
        let (dx, dy) = (i64::from(b.x - a.x), i64::from(b.y - a.y));
        let area = dx * i64::from(c.y - a.y) - dy * i64::from(c.x - a.x);
        if area == 0 {
            return None;
        }
        let sign = area.signum() as f32;
        let length = ((dx * dx + dy * dy) as f32).sqrt();
        Some([sign * dy as f32 / length, -sign * dx as f32 / length])
    }
}
