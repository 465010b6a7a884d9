//! Which arithmetic evaluates a patch: the cheapest whose bound fits.

use super::abi;
use super::clocks::CLOCKS;
use super::precision::{Arithmetic, Bound, Hull, LARGEST_TENSOR_DEGREE};
use crate::stages::cull::ROUNDING_BUDGET;
use serde::{Deserialize, Serialize};

/// What patches are evaluated in. Degrees above 7 are always in f32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
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

/// Clocks of a multiprocessor that a meshlet takes.
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
    /// Of a device, or of the newest one before it.
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

impl Precision {
    /// The arithmetic of a patch whose grid leaves `rounding` pixels to evaluation. f32 takes what nothing cheaper fits.
    pub fn choose(self, view: &abi::View, hull: &Hull, rounding: f64, clocks: &Clocks) -> Arithmetic {
        let chosen = match self {
            Self::F32 => Arithmetic::F32,
            Self::F16 => Arithmetic::F16,
            Self::F16Recovered => Arithmetic::F16Recovered,
            Self::F16Sparse => Arithmetic::F16Sparse,
            Self::Tf32 => Arithmetic::Tf32,
            Self::Tf32Recovered => Arithmetic::Tf32Recovered,
            Self::Auto => {
                let single = Arithmetic::F32.bound(hull);
                let take = |a: &Arithmetic| clocks.take(*a, hull.degree);
                let fits = |a: &Arithmetic| *a == Arithmetic::F32 || a.bound(hull).fits(view, hull, rounding, &single);
                let fitting = Arithmetic::ALL.into_iter().filter(fits);
                fitting.min_by(|a, b| take(a).total_cmp(&take(b))).unwrap_or(Arithmetic::F32)
            }
        };
        chosen.for_degree(hull.degree)
    }

    /// Pixels that the tolerance has to leave to the evaluation of a patch, before its grid is made.
    pub fn rounding(self, view: &abi::View, hull: &Hull) -> f64 {
        let pixels = |arithmetic: Arithmetic| arithmetic.bound(hull).pixels(view, hull.reach);
        match self {
            Self::F32 => pixels(Arithmetic::F32),
            Self::F16 => pixels(Arithmetic::F16),
            Self::F16Recovered => pixels(Arithmetic::F16Recovered),
            Self::F16Sparse => pixels(Arithmetic::F16Sparse),
            Self::Tf32 => pixels(Arithmetic::Tf32),
            Self::Tf32Recovered => pixels(Arithmetic::Tf32Recovered),
            Self::Auto => pixels(Arithmetic::F32).max(ROUNDING_BUDGET),
        }
    }
}

impl Bound {
    /// Pixels, of the place and of the parameters between.
    pub fn pixels(&self, view: &abi::View, reach: f64) -> f64 {
        self.place + self.parameter(view, reach)
    }

    /// Depth, in pixel sizes, may be off as far, or as far as in f32.
    fn fits(&self, view: &abi::View, hull: &Hull, rounding: f64, single: &Self) -> bool {
        self.pixels(view, hull.reach) <= rounding
            && self.depth_in_pixels(view) <= single.depth_in_pixels(view).max(rounding)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A100: [i32; 2] = [8, 0];
    const H100: [i32; 2] = [9, 0];

    fn view() -> abi::View {
        abi::View { scale: 1000.0, extent: 1.0, ..abi::View::default() }
    }

    fn hull(degree: u8, reach: f64) -> Hull {
        Hull { degree: [degree; 2], reach, range: 1.0, cancellation: 1.0, relief: 0.0 }
    }

    fn auto(device: [i32; 2], hull: &Hull) -> Arithmetic {
        Precision::Auto.choose(&view(), hull, ROUNDING_BUDGET, Clocks::of(device))
    }

    fn is_plain(arithmetic: Arithmetic) -> bool {
        matches!(arithmetic, Arithmetic::F16 | Arithmetic::Tf32)
    }

    #[test]
    fn only_small_patches_are_rounded_to_eleven_bits() {
        // 4.5 * 2^-11 of the reach is 1/256 at 1.74 pixels.
        assert!(is_plain(auto(H100, &hull(7, 1.7))));
        assert_eq!(auto(H100, &hull(7, 1.8)), Arithmetic::F16Recovered);
        // f32 is as exact as it gets: larger patches are split.
        assert_eq!(auto(H100, &hull(7, 1e5)), Arithmetic::F32);
    }

    #[test]
    fn what_is_chosen_fits_and_nothing_cheaper_does() {
        for clocks in &CLOCKS {
            for (degree, reach) in (1..=7).flat_map(|d| [0.5, 1.7, 30.0, 700.0, 5e4].map(|reach| (d, reach))) {
                let hull = hull(degree, reach);
                let chosen = Precision::Auto.choose(&view(), &hull, ROUNDING_BUDGET, clocks);
                for other in Arithmetic::ALL {
                    let fits = other.bound(&hull).pixels(&view(), reach) <= ROUNDING_BUDGET;
                    assert!(other != chosen || fits || other == Arithmetic::F32, "{chosen:?} {hull:?}");
                    let cheaper = clocks.take(other, hull.degree) < clocks.take(chosen, hull.degree);
                    assert!(!fits || !cheaper, "{other:?} would do for {hull:?} on {}", clocks.target);
                }
            }
        }
    }

    #[test]
    fn depth_keeps_a_patch_out_of_f16() {
        let flat = Hull { relief: 1e-4, ..hull(7, 1.0) };
        let deep = Hull { relief: 1.0, cancellation: 3.0, ..hull(7, 1.0) };
        let perspective = abi::View { perspective: 1, ..view() };
        let auto = |hull| Precision::Auto.choose(&perspective, hull, ROUNDING_BUDGET, Clocks::of(H100));
        assert!(is_plain(auto(&flat)) && !is_plain(auto(&deep)));
    }

    #[test]
    fn higher_degrees_are_in_f32() {
        for precision in [Precision::Auto, Precision::F16, Precision::Tf32Recovered] {
            let chosen = precision.choose(&view(), &hull(8, 1.0), 1.0, Clocks::of(A100));
            assert_eq!(chosen, Arithmetic::F32);
        }
    }

    #[test]
    fn newer_devices_are_like_the_newest_known() {
        assert_eq!([[7, 5], [8, 0], [8, 7], [10, 0], [13, 0]].map(|c| Clocks::of(c).target), [80, 80, 86, 90, 120]);
    }
}
