//! Which pixels are checked.

use crate::stages::Pixel;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashSet};

/// All pixels, or some.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampling {
    /// `Some(n)`: n pixels of the image, n more where the 3x3 neighbourhood shows more than one patch or background, and
    /// all filled pixels with their neighbours.
    pub samples: Option<usize>,
    pub seed: u64,
}

/// What tells a pixel's neighbours apart.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Mark {
    /// Instance and patch; `None` for background.
    shown: Option<(u32, u32)>,
    filled: bool,
}

/// The pixels to check as sorted indices `y * width + x`; `None` for all.
pub(super) fn choose(
    size: [u32; 2],
    pixels: &(impl Fn(u32, u32) -> Option<Pixel> + Sync),
    sampling: &Sampling,
) -> Option<Vec<u32>> {
    let count = sampling.samples?;
    let all = (size[0] as usize) * (size[1] as usize);
    if count >= all {
        return None;
    }
    let marks: Vec<Mark> = (0..all as u32)
        .into_par_iter()
        .map(|at| {
            let pixel = pixels(at % size[0], at / size[0]);
            Mark { shown: pixel.map(|p| (p.instance, p.patch)), filled: pixel.is_some_and(|p| p.filled) }
        })
        .collect();
    let seams: Vec<u32> = (0..all as u32)
        .into_par_iter()
        .filter(|&at| neighbours(size, at).any(|n| marks[n as usize].shown != marks[at as usize].shown))
        .collect();
    let mut random = SplitMix(sampling.seed);
    let mut chosen: BTreeSet<u32> = random.choose(all, count).into_iter().map(|i| i as u32).collect();
    chosen.extend(random.choose(seams.len(), count).into_iter().map(|i| seams[i]));
    for at in (0..all as u32).filter(|&at| marks[at as usize].filled) {
        chosen.extend(neighbours(size, at));
    }
    Some(chosen.into_iter().collect())
}

/// A pixel and its neighbours inside the image.
fn neighbours([width, height]: [u32; 2], at: u32) -> impl Iterator<Item = u32> {
    let (x, y) = (at % width, at / width);
    let range = |c: u32, end: u32| c.saturating_sub(1)..(c + 2).min(end);
    range(y, height).flat_map(move |y| range(x, width).map(move |x| y * width + x))
}

/// Steele, Lea, Flood. Fast splittable pseudorandom number generators. 2014.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to `end` - 1.
    fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.next()) * end as u128) >> 64) as usize
    }

    /// `count` different numbers below `end`, all of them where there are not enough (Floyd's algorithm; Bentley.
    /// Programming pearls: a sample of brilliance. 1987).
    fn choose(&mut self, end: usize, count: usize) -> HashSet<usize> {
        let mut chosen = HashSet::new();
        for last in end.saturating_sub(count)..end {
            let pick = self.below(last + 1);
            if !chosen.insert(pick) {
                chosen.insert(last);
            }
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_different_and_repeatable() {
        let pick = |seed| SplitMix(seed).choose(1000, 400);
        assert_eq!(pick(1).len(), 400);
        assert_eq!(pick(1), pick(1));
        assert_ne!(pick(1), pick(2));
        assert_eq!(SplitMix(3).choose(5, 9).len(), 5);
    }

    #[test]
    fn filled_pixels_and_seams_are_chosen() {
        let pixels = |x: u32, y: u32| {
            (x >= 5).then_some(Pixel {
                instance: 0,
                patch: 0,
                interpolated: [0.0; 2],
                stored: [0.0; 2],
                depth: 1.0,
                filled: (x, y) == (20, 30),
            })
        };
        let chosen = choose([40, 40], &pixels, &Sampling { samples: Some(60), seed: 7 }).unwrap();
        let at = |i: &u32| (i % 40, i / 40);
        // The seam is columns 4 and 5, 80 pixels.
        assert!(chosen.iter().filter(|i| matches!(at(i).0, 4 | 5)).count() >= 60);
        for y in 29..32 {
            for x in 19..22 {
                assert!(chosen.contains(&(y * 40 + x)));
            }
        }
        assert!(choose([40, 40], &pixels, &Sampling { samples: Some(1600), seed: 7 }).is_none());
    }
}
