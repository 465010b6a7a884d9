//! What evaluation takes on a GPU, as `bench evaluate` measured it there, kept in the user's cache: `--precision auto` goes by it
//! where it is, else by computed clocks. Whatever is chosen fits the tolerance; only speed hangs on it.

use super::precision::{Arithmetic, LARGEST_TENSOR_DEGREE};
use super::selection::Clocks;
use crate::cache;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// Nanoseconds a meshlet of one degree in u and v.
pub type Times = BTreeMap<Arithmetic, BTreeMap<u8, f64>>;

/// Where they are kept.
pub fn file() -> io::Result<PathBuf> {
    cache::file("evaluate.json")
}

/// What was measured on a device with this driver.
pub fn stored(device: &str) -> Option<Times> {
    cache::get(&file().ok()?, device)
}

/// Keeps them beside those of other devices, and of degrees that were measured before.
pub fn store(file: &Path, device: &str, times: &Times) -> io::Result<()> {
    let mut all: Times = cache::get(file, device).unwrap_or_default();
    for (&arithmetic, by_degree) in times {
        all.entry(arithmetic).or_default().extend(by_degree);
    }
    cache::put(file, device, &all)
}

impl Clocks {
    /// These, computed for a device, with measured ones in their place; `None` where an arithmetic was not measured. Degrees
    /// that were not are scaled as the nearest one that was. Products of tensor cores are the same for all degrees, and so is
    /// their time here: the mean.
    pub fn measured(&self, times: &Times) -> Option<Self> {
        let degrees = 1..=LARGEST_TENSOR_DEGREE;
        let of = |arithmetic: Arithmetic| {
            // Nobody's file is trusted with what is no time.
            let sound = |(degree, time): (&u8, &f64)| {
                (degrees.contains(degree) && time.is_finite() && *time > 0.0).then_some((*degree, *time))
            };
            let found: Vec<(u8, f64)> = times.get(&arithmetic)?.iter().filter_map(sound).collect();
            (!found.is_empty()).then_some(found)
        };
        let mean = |arithmetic| {
            let found = of(arithmetic)?;
            Some(found.iter().map(|(_, time)| time).sum::<f64>() / found.len() as f64)
        };
        let single = of(Arithmetic::F32)?;
        let computed = |degree: u8| self.f32[usize::from(degree) - 1];
        let of_degree = |degree: u8| {
            let nearest = single.iter().min_by_key(|(measured, _)| measured.abs_diff(degree));
            nearest.map_or(0.0, |&(measured, time)| time * (computed(degree) / computed(measured)))
        };
        Some(Self {
            target: self.target,
            f32: std::array::from_fn(|k| of_degree(k as u8 + 1)),
            f16: mean(Arithmetic::F16)?,
            f16_recovered: mean(Arithmetic::F16Recovered)?,
            tf32: mean(Arithmetic::Tf32)?,
            tf32_recovered: mean(Arithmetic::Tf32Recovered)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H100: [i32; 2] = [9, 0];

    /// f32 twice as many nanoseconds as clocks; all others so many.
    fn times(recovered: f64) -> Times {
        let f32 = BTreeMap::from([3, 4, 7].map(|degree| (degree, 2.0 * Clocks::of(H100).f32[usize::from(degree) - 1])));
        let others = Arithmetic::ALL.into_iter().filter(|a| *a != Arithmetic::F32);
        let mut all: Times = others.map(|a| (a, BTreeMap::from([(3, 1000.0), (7, 1200.0)]))).collect();
        all.insert(Arithmetic::F32, f32);
        all.insert(Arithmetic::Tf32Recovered, BTreeMap::from([(3, recovered), (7, recovered)]));
        all
    }

    #[test]
    fn measured_times_take_the_place_of_computed_ones() {
        let computed = Clocks::of(H100);
        let measured = computed.measured(&times(50.0)).expect("complete");
        for (found, clocks) in measured.f32.iter().zip(computed.f32) {
            assert!((found - 2.0 * clocks).abs() < 1e-9, "{measured:?}");
        }
        assert_eq!((measured.f16, measured.tf32_recovered, measured.target), (1100.0, 50.0, 90));
    }

    #[test]
    fn partial_times_are_none() {
        let computed = Clocks::of(H100);
        let with = |arithmetic, by_degree: &[(u8, f64)]| {
            let mut times = times(50.0);
            times.insert(arithmetic, by_degree.iter().copied().collect());
            computed.measured(&times)
        };
        for bad in [&[][..], &[(0, 1.0), (8, 1.0)], &[(3, 0.0)], &[(3, -1.0)], &[(3, f64::NAN)], &[(3, f64::INFINITY)]]
        {
            assert_eq!(with(Arithmetic::F32, bad), None, "{bad:?}");
            assert_eq!(with(Arithmetic::F16Recovered, bad), None, "{bad:?}");
        }
        assert_eq!(with(Arithmetic::F16, &[(3, 7.0), (5, f64::NAN), (9, 1.0)]).map(|c| c.f16), Some(7.0));
        assert_eq!(computed.measured(&Times::new()), None);
    }

    #[test]
    fn a_device_keeps_what_was_measured_before() {
        let folder = std::env::temp_dir().join(format!("halfpixel-evaluate-{}", std::process::id()));
        let file = folder.join("evaluate.json");
        let get = |device: &str| cache::get::<Times>(&file, device);
        store(&file, "one", &times(50.0)).unwrap();
        let other = Times::from([(Arithmetic::F32, BTreeMap::from([(3, 1.0), (5, 2.0)]))]);
        store(&file, "one", &other).unwrap();
        store(&file, "two", &other).unwrap();
        let mut both = times(50.0);
        both.entry(Arithmetic::F32).or_default().extend([(3, 1.0), (5, 2.0)]);
        assert_eq!((get("one"), get("two"), get("three")), (Some(both), Some(other), None));
        // Arithmetics that this version does not know, or what is no table at all.
        for broken in [r#"{"one": {"f8": {"3": 1.0}}}"#, r#"{"one": {"f32": [1.0]}}"#, r#"{"one": 3}"#, "{"] {
            std::fs::write(&file, broken).unwrap();
            assert_eq!(get("one"), None, "{broken}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
