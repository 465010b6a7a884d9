//! Which arithmetic evaluates a patch: the cheapest whose bound fits.

use super::abi;
use super::clocks::CLOCKS;
use super::precision::{Arithmetic, Bound, Hull, LARGEST_TENSOR_DEGREE};
use serde::{Deserialize, Serialize};

/// What patches are evaluated in. Degrees above 7 are always in f32.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// The cheapest whose error fits, patch by patch.
    Auto,
    /// Single precision, as the CPU: the same words.
    #[default]
    F32,
    /// f16 on tensor cores.
    F16,
    /// f16 on tensor cores with single precision recovered.
    F16Recovered,
    /// f16 on tensor cores by sparse products, as in ETER's table 3.
    F16Sparse,
    /// tf32 on tensor cores.
    Tf32,
    /// tf32 on tensor cores with single precision recovered.
    Tf32Recovered,
}

/// What evaluating a meshlet takes: clocks of a multiprocessor, or nanoseconds of a device. Only their order counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clocks {
    /// The compute capability: 86 is 8.6.
    pub target: u32,
    /// Of degrees 1 to 7.
    pub f32: [f64; LARGEST_TENSOR_DEGREE as usize],
    pub f16: f64,
    pub f16_recovered: f64,
    pub tf32: f64,
    pub tf32_recovered: f64,
}

impl Clocks {
    /// As computed for a device, or for the newest one before it.
    pub fn of([major, minor]: [i32; 2]) -> &'static Self {
        let target = major.unsigned_abs() * 10 + minor.unsigned_abs();
        CLOCKS.iter().rev().find(|c| c.target <= target).unwrap_or(&CLOCKS[0])
    }

    /// The kernel for unequal degrees does not take fewer than that of the larger one.
    fn take(&self, arithmetic: Arithmetic, degree: [u8; 2]) -> f64 {
        match arithmetic {
            Arithmetic::F32 => self.f32[usize::from(degree[0].max(degree[1]).clamp(1, LARGEST_TENSOR_DEGREE)) - 1],
            // As many clocks on paper; ETER measured no gain.
            Arithmetic::F16 | Arithmetic::F16Sparse => self.f16,
            Arithmetic::F16Recovered => self.f16_recovered,
            Arithmetic::Tf32 => self.tf32,
            Arithmetic::Tf32Recovered => self.tf32_recovered,
        }
    }
}

/// Shares of both tolerances that evaluation may take: where the arithmetic was asked for by name, patches are halved until it
/// takes no more; chosen ones must not cost quads.
const NAMED_SHARE: f64 = 1.0 / 4.0;
const CHOSEN_SHARE: f64 = 1.0 / 32.0;
/// Vertices of a block that keep a warp of tensor cores busier than its lanes would be in f32.
const LARGE_BLOCK: u32 = 32;

/// By what the patches of a frame get their arithmetic. Twin of kernels/precision.cuh.
#[derive(Clone, Copy, Debug)]
pub struct Selection {
    pub precision: Precision,
    pub clocks: Clocks,
    /// Only grids that are cut into large blocks are for tensor cores: the fused frame evaluates smaller ones where they are
    /// drawn.
    pub large_blocks: bool,
}

/// What a patch is evaluated in, and what that takes of the tolerances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    pub arithmetic: Arithmetic,
    /// Pixels, of the place and of the parameters between vertices.
    pub pixels: f64,
    /// Pixel sizes of depth, beyond what f32 is off by.
    pub depth: f64,
}

impl Precision {
    /// The one that is asked for by name; None: whatever fits.
    pub fn named(self) -> Option<Arithmetic> {
        match self {
            Self::Auto => None,
            Self::F32 => Some(Arithmetic::F32),
            Self::F16 => Some(Arithmetic::F16),
            Self::F16Recovered => Some(Arithmetic::F16Recovered),
            Self::F16Sparse => Some(Arithmetic::F16Sparse),
            Self::Tf32 => Some(Arithmetic::Tf32),
            Self::Tf32Recovered => Some(Arithmetic::Tf32Recovered),
        }
    }
}

impl Selection {
    /// The CPU's.
    pub const SINGLE: &Self = &Self { precision: Precision::F32, clocks: CLOCKS[0], large_blocks: false };

    /// The arithmetic of a patch; None: the one asked for takes too much of the tolerances, unless the patch is halved. f32
    /// takes whatever nothing cheaper fits.
    pub fn choose(&self, view: &abi::View, hull: &Hull) -> Option<Chosen> {
        let single = Arithmetic::F32.bound(hull);
        let taken = |arithmetic: Arithmetic| {
            let bound = arithmetic.bound(hull);
            let beyond = Bound { depth: (bound.depth - single.depth).max(0.0), ..bound };
            Chosen { arithmetic, pixels: bound.pixels(view, hull.reach), depth: beyond.depth_in_pixels(view) }
        };
        let fits =
            |c: &Chosen, share: f64| c.pixels <= view.tolerance * share && c.depth <= view.depth_tolerance * share;
        let mut best = taken(Arithmetic::F32);
        match self.precision.named().map(|arithmetic| arithmetic.for_degree(hull.degree)) {
            Some(Arithmetic::F32) => {}
            Some(arithmetic) => {
                best = taken(arithmetic);
                return fits(&best, NAMED_SHARE).then_some(best);
            }
            None => {
                for arithmetic in Arithmetic::ALL.into_iter().filter(|a| a.for_degree(hull.degree) == *a) {
                    let clocks = |a: Arithmetic| self.clocks.take(a, hull.degree);
                    if clocks(arithmetic) < clocks(best.arithmetic) {
                        let other = taken(arithmetic);
                        best = if fits(&other, CHOSEN_SHARE) { other } else { best };
                    }
                }
            }
        }
        Some(best)
    }

    /// What a leaf with this grid is evaluated in.
    pub fn of_grid(&self, arithmetic: Arithmetic, quads: [u32; 2]) -> Arithmetic {
        let most = abi::MESHLET_VERTICES - 1;
        let lines = quads.map(|n| n.div_ceil(n.div_ceil(most)) + 1);
        if self.large_blocks && lines[0] * lines[1] < LARGE_BLOCK { Arithmetic::F32 } else { arithmetic }
    }

    /// As kernels get it: precision, large blocks, clocks of f32 by degree, of all by number.
    pub(crate) fn rules(&self) -> abi::Rules {
        abi::Rules {
            precision: self.precision.named().map_or(abi::PRECISION_AUTO, |arithmetic| arithmetic as u32),
            large_blocks: self.large_blocks.into(),
            f32_clocks: self.clocks.f32,
            clocks: Arithmetic::ALL.map(|arithmetic| self.clocks.take(arithmetic, [LARGEST_TENSOR_DEGREE; 2])),
            ..abi::Rules::default()
        }
    }
}

impl Bound {
    /// Pixels, of the place and of the parameters between.
    pub fn pixels(&self, view: &abi::View, reach: f64) -> f64 {
        self.place + self.parameter(view, reach)
    }
}

#[cfg(test)]
mod tests {
    use super::super::measured::Times;
    use super::*;
    use std::collections::BTreeMap;

    const A100: [i32; 2] = [8, 0];
    const H100: [i32; 2] = [9, 0];

    fn view() -> abi::View {
        abi::View { scale: 1000.0, extent: 1.0, tolerance: 0.5, depth_tolerance: 1.0, ..abi::View::default() }
    }

    fn hull(degree: u8, reach: f64) -> Hull {
        Hull { degree: [degree; 2], reach, range: 1.0, cancellation: 1.0, relief: 0.0 }
    }

    fn selection(precision: Precision, device: [i32; 2]) -> Selection {
        Selection { precision, clocks: *Clocks::of(device), large_blocks: false }
    }

    fn auto(device: [i32; 2], hull: &Hull) -> Arithmetic {
        selection(Precision::Auto, device).choose(&view(), hull).expect("f32 always does").arithmetic
    }

    fn is_plain(arithmetic: Arithmetic) -> bool {
        matches!(arithmetic, Arithmetic::F16 | Arithmetic::Tf32)
    }

    #[test]
    fn only_small_patches_are_rounded_to_eleven_bits() {
        // 4.5 * 2^-11 of the reach is 1/64 at 7 pixels.
        assert!(is_plain(auto(H100, &hull(7, 6.9))));
        assert_eq!(auto(H100, &hull(7, 7.2)), Arithmetic::F16Recovered);
        // f32 is as exact as it gets: larger patches are split.
        assert_eq!(auto(H100, &hull(7, 1e5)), Arithmetic::F32);
    }

    #[test]
    fn what_is_chosen_fits_and_nothing_cheaper_does() {
        for clocks in CLOCKS {
            let selection = Selection { precision: Precision::Auto, clocks, large_blocks: false };
            for (degree, reach) in (1..=7).flat_map(|d| [0.5, 1.7, 30.0, 700.0, 5e4].map(|reach| (d, reach))) {
                let hull = hull(degree, reach);
                let chosen = selection.choose(&view(), &hull).expect("f32 always does").arithmetic;
                for other in Arithmetic::ALL {
                    let fits = other.bound(&hull).pixels(&view(), reach) <= 0.5 * CHOSEN_SHARE;
                    assert!(other != chosen || fits || other == Arithmetic::F32, "{chosen:?} {hull:?}");
                    let cheaper = clocks.take(other, hull.degree) < clocks.take(chosen, hull.degree);
                    assert!(!fits || !cheaper, "{other:?} would do for {hull:?} on {}", clocks.target);
                }
            }
        }
    }

    #[test]
    fn what_was_measured_changes_the_choice() {
        let computed = Clocks::of(H100);
        let times = |f32: f64, tf32_recovered: f64| {
            let one = |time: f64| BTreeMap::from([(3, time), (7, time)]);
            let time = |a| match a {
                Arithmetic::F32 => f32,
                Arithmetic::Tf32Recovered => tf32_recovered,
                _ => 5.0,
            };
            Arithmetic::ALL.into_iter().map(|a| (a, one(time(a)))).collect::<Times>()
        };
        let chosen = |clocks: Clocks| {
            let selection = Selection { clocks, ..selection(Precision::Auto, H100) };
            selection.choose(&view(), &hull(7, 30.0)).map(|c| c.arithmetic)
        };
        let measured = |f32, tf32_recovered| chosen(computed.measured(&times(f32, tf32_recovered)).expect("complete"));
        assert_eq!(chosen(*computed), Some(Arithmetic::F16Recovered));
        assert_eq!(measured(4.0, 4.5), Some(Arithmetic::F32));
        assert_eq!(measured(6.0, 4.5), Some(Arithmetic::Tf32Recovered));
        assert_eq!(measured(6.0, 7.0), Some(Arithmetic::F16Recovered));
    }

    #[test]
    fn depth_keeps_a_patch_out_of_f16() {
        let flat = Hull { relief: 1e-4, ..hull(7, 1.0) };
        let deep = Hull { relief: 1.0, cancellation: 3.0, ..hull(7, 1.0) };
        let perspective = abi::View { perspective: 1, ..view() };
        let auto = |hull| selection(Precision::Auto, H100).choose(&perspective, hull).map(|c| c.arithmetic);
        assert!(auto(&flat).is_some_and(is_plain) && !auto(&deep).is_some_and(is_plain));
        assert_eq!(selection(Precision::F16, H100).choose(&perspective, &deep), None);
    }

    #[test]
    fn patches_are_halved_for_what_is_asked_for_by_name() {
        // 4.5 * 2^-11 of the reach is 1/8 at 56 pixels.
        let f16 = |reach| selection(Precision::F16, A100).choose(&view(), &hull(7, reach));
        assert!(f16(50.0).is_some() && f16(60.0).is_none());
        assert!(selection(Precision::F16Recovered, A100).choose(&view(), &hull(7, 1000.0)).is_some());
    }

    #[test]
    fn higher_degrees_are_in_f32() {
        for precision in [Precision::Auto, Precision::F16, Precision::Tf32Recovered] {
            let chosen = selection(precision, A100).choose(&view(), &hull(8, 1.0)).map(|c| c.arithmetic);
            assert_eq!(chosen, Some(Arithmetic::F32));
        }
    }

    #[test]
    fn only_large_blocks_are_for_tensor_cores_where_there_is_no_memory_for_vertices() {
        let fused = Selection { large_blocks: true, ..selection(Precision::F16Recovered, A100) };
        let of = |quads| fused.of_grid(Arithmetic::F16Recovered, quads);
        assert_eq!([[7, 7], [4, 6], [14, 3]].map(of), [Arithmetic::F16Recovered; 3]);
        // Eight quads are four and four.
        assert_eq!([[1, 1], [4, 5], [8, 5]].map(of), [Arithmetic::F32; 3]);
    }

    #[test]
    fn newer_devices_are_like_the_newest_known() {
        assert_eq!([[7, 5], [8, 0], [8, 7], [10, 0], [13, 0]].map(|c| Clocks::of(c).target), [80, 80, 86, 90, 120]);
    }
}
