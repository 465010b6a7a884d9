//! From verdicts to numbers.

use super::Oracle;
use super::check::{Check, Verdict};
use super::error_image::{Class, ErrorMap};
use super::sample::{Sampling, choose};
use crate::scene::{Camera, Scene};
use crate::stages::{Options, Pixel};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// What `verify` found in one frame (DESIGN sections 6 and 7).
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Pixels checked, background included.
    pub pixels: u64,
    /// Of these, pixels that show a surface.
    pub drawn: u64,
    /// Of the interpolated parameter, over centre-covered pixels.
    pub grid_error_px: Option<ErrorStats>,
    /// Of the stored parameter, over drawn pixels.
    pub parametric_error_px: Option<ErrorStats>,
    /// The same, over pixels whose centre ray meets the stored patch.
    pub refined_error_px: Option<ErrorStats>,
    /// Pixels whose grid or parametric error is beyond half a pixel.
    pub violations: u64,
    pub cracks: u64,
    pub covering_failures: u64,
    pub depth_failures: u64,
    /// Checked pixels that the stroke buffer decided.
    pub filled: u64,
    /// The worst pixels of each kind of failure.
    pub worst: Vec<Offender>,
    /// What the check took.
    pub seconds: f64,
    /// The verdict on every checked pixel, for the error image.
    #[serde(skip)]
    pub map: ErrorMap,
}

/// Errors in pixels, L-infinity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorStats {
    pub max: f64,
    /// The smallest error that 99.9 % of the pixels do not exceed.
    pub p999: f64,
    pub mean: f64,
}

/// A pixel that breaks the contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Offender {
    pub kind: Failure,
    pub x: u32,
    pub y: u32,
    /// What the frame shows there; `None` for background.
    pub instance: Option<u32>,
    pub patch: Option<u32>,
    /// The instance's name and the file's number of the face, to find it there.
    pub name: Option<String>,
    pub face: Option<u32>,
    /// The larger of grid and parametric error.
    pub error_px: Option<f64>,
}

/// The ways to break the contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Failure {
    Violation,
    Crack,
    CoveringFailure,
    DepthFailure,
}

impl Failure {
    pub fn name(self) -> &'static str {
        match self {
            Self::Violation => "violation",
            Self::Crack => "crack",
            Self::CoveringFailure => "covering failure",
            Self::DepthFailure => "depth failure",
        }
    }
}

/// Memory that the oracle may hold between batches for patches and trims that rays came near.
const MOST_BYTES: usize = 1 << 30;

/// Pixels are judged in so many tasks where each then has enough work and not too much of it.
const TASKS: usize = 2048;
const SMALLEST_TASK: usize = 64;
const LARGEST_TASK: usize = 4096;
/// Between batches no task runs.
const TASKS_A_BATCH: usize = 64;

/// Offenders listed of each kind.
const WORST_OF_A_KIND: usize = 16;

/// Sums over pixels; errors are kept (4 bytes each), since a percentile needs them all.
#[derive(Default)]
struct Tally {
    pixels: u64,
    drawn: u64,
    filled: u64,
    /// In the order of `Failure`.
    failures: [u64; 4],
    /// Grid, parametric, refined.
    errors: [Vec<f32>; 3],
    worst: Vec<Offender>,
}

impl Report {
    /// The contract holds on every checked pixel.
    pub fn passed(&self) -> bool {
        self.violations == 0 && self.cracks == 0 && self.covering_failures == 0 && self.depth_failures == 0
    }
}

/// Checks a frame against the exact surfaces.
///
/// `pixels(x, y)` is what the frame of `scene` under `camera` shows, `None` for background. `options` gives the depth
/// tolerance. `progress(done, all)` is called now and then, from any thread.
pub fn verify(
    scene: &Scene,
    camera: &Camera,
    options: &Options,
    pixels: &(impl Fn(u32, u32) -> Option<Pixel> + Sync),
    sampling: &Sampling,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Report {
    judge_in_batches(scene, camera, options, pixels, sampling, progress, MOST_BYTES)
}

/// As [`verify`]; what the oracle makes for rays is dropped between batches where it exceeds `most_bytes`.
fn judge_in_batches(
    scene: &Scene,
    camera: &Camera,
    options: &Options,
    pixels: &(impl Fn(u32, u32) -> Option<Pixel> + Sync),
    sampling: &Sampling,
    progress: &(dyn Fn(usize, usize) + Sync),
    most_bytes: usize,
) -> Report {
    let start = Instant::now();
    let mut oracle = Oracle::new(scene, camera);
    let [width, height] = camera.size;
    let chosen = choose(camera.size, pixels, sampling);
    let count = chosen.as_ref().map_or(width as usize * height as usize, Vec::len);
    let at = |i: usize| chosen.as_ref().map_or(i as u32, |chosen| chosen[i]);
    let task = (count / TASKS).clamp(SMALLEST_TASK, LARGEST_TASK);
    let done = AtomicUsize::new(0);
    let mut tally = Tally::default();
    let mut map = ErrorMap::new(camera.size);
    // Pixels go row by row, so what one batch needs the next one mostly needs too.
    for batch in (0..count).step_by(task * TASKS_A_BATCH) {
        if oracle.bytes() > most_bytes {
            oracle.forget();
        }
        let check = Check { oracle: &oracle, depth_tolerance: options.depth_tolerance };
        let end = count.min(batch + task * TASKS_A_BATCH);
        let judge = |from: usize| {
            let range = from..end.min(from + task);
            let mut tally = Tally::default();
            let classes: Vec<Class> = range
                .clone()
                .map(|i| {
                    let (x, y) = (at(i) % width, at(i) / width);
                    let pixel = pixels(x, y);
                    let verdict = check.judge(x, y, pixel.as_ref());
                    tally.add(x, y, pixel.as_ref(), &verdict);
                    Class::of(pixel.is_some(), &verdict)
                })
                .collect();
            progress(done.fetch_add(range.len(), Ordering::Relaxed) + range.len(), count);
            (range, tally, classes)
        };
        let parts: Vec<_> = (batch..end).into_par_iter().step_by(task).map(judge).collect();
        for (range, of_part, classes) in parts {
            for (i, class) in range.zip(classes) {
                map.set(at(i) as usize, class);
            }
            tally.join(of_part);
        }
    }
    let mut report = tally.report(map, start.elapsed().as_secs_f64());
    report.worst.iter_mut().for_each(|offender| offender.find(scene));
    report
}

impl Offender {
    /// Says what the scene calls what is shown.
    fn find(&mut self, scene: &Scene) {
        let instance = self.instance.and_then(|i| scene.instances.get(i as usize));
        self.name = instance.map(|i| i.name.clone()).filter(|name| !name.is_empty());
        let patch = self.patch.and_then(|p| scene.patches.get(p as usize));
        self.face = patch.map(|p| scene.faces[p.face as usize].id);
    }
}

impl Tally {
    fn add(&mut self, x: u32, y: u32, pixel: Option<&Pixel>, verdict: &Verdict) {
        self.pixels += 1;
        self.drawn += u64::from(pixel.is_some());
        self.filled += u64::from(pixel.is_some_and(|p| p.filled));
        let errors = [verdict.grid_error, verdict.parametric_error, verdict.refined_error];
        for (all, error) in self.errors.iter_mut().zip(errors) {
            all.extend(error.map(|e| e.min(f64::from(f32::MAX)) as f32));
        }
        let kinds = [
            (Failure::Violation, verdict.violation()),
            (Failure::Crack, verdict.crack),
            (Failure::CoveringFailure, verdict.covering_failure),
            (Failure::DepthFailure, verdict.depth_failure),
        ];
        for (kind, _) in kinds.into_iter().filter(|(_, failed)| *failed) {
            self.failures[kind as usize] += 1;
            let (instance, patch) = (pixel.map(|p| p.instance), pixel.map(|p| p.patch));
            let error_px = verdict.worst_error();
            self.worst.push(Offender { kind, x, y, instance, patch, name: None, face: None, error_px });
        }
        if self.worst.len() > 8 * WORST_OF_A_KIND {
            self.keep_worst();
        }
    }

    fn join(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.drawn += other.drawn;
        self.filled += other.filled;
        for (sum, more) in self.failures.iter_mut().zip(other.failures) {
            *sum += more;
        }
        for (all, more) in self.errors.iter_mut().zip(other.errors) {
            all.extend(more);
        }
        self.worst.extend(other.worst);
        self.keep_worst();
    }

    /// Drops all but the worst of each kind; by kind, then error, then place.
    fn keep_worst(&mut self) {
        self.worst.sort_by(|a, b| {
            let error = |o: &Offender| o.error_px.unwrap_or(0.0);
            a.kind.cmp(&b.kind).then(error(b).total_cmp(&error(a))).then((a.y, a.x).cmp(&(b.y, b.x)))
        });
        let mut kept = [0; 4];
        self.worst.retain(|o| {
            kept[o.kind as usize] += 1;
            kept[o.kind as usize] <= WORST_OF_A_KIND
        });
    }

    fn report(self, map: ErrorMap, seconds: f64) -> Report {
        let [grid, parametric, refined] = self.errors.map(ErrorStats::of);
        let [violations, cracks, covering_failures, depth_failures] = self.failures;
        Report {
            pixels: self.pixels,
            drawn: self.drawn,
            grid_error_px: grid,
            parametric_error_px: parametric,
            refined_error_px: refined,
            violations,
            cracks,
            covering_failures,
            depth_failures,
            filled: self.filled,
            worst: self.worst,
            seconds,
            map,
        }
    }
}

impl ErrorStats {
    fn of(mut errors: Vec<f32>) -> Option<Self> {
        let count = errors.len();
        if count == 0 {
            return None;
        }
        let rank = ((count as f64 * 0.999).ceil() as usize).clamp(1, count) - 1;
        let max = errors.iter().copied().fold(0.0, f32::max);
        let mean = errors.iter().map(|&e| f64::from(e)).sum::<f64>() / count as f64;
        let (_, p999, _) = errors.select_nth_unstable_by(rank, f32::total_cmp);
        Some(Self { max: f64::from(max), p999: f64::from(*p999), mean })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ViewSpec, prepare};
    use crate::stages::Renderer;

    /// A model whose trims, edges and silhouettes rays come near, before an oracle that keeps all it made and one that
    /// forgets it after every batch.
    #[test]
    fn an_oracle_that_forgets_says_the_same() {
        let model = crate::import::load("builtin:trimmed:gap").unwrap();
        let scene = prepare(&model, &|_, _| {}).unwrap();
        let camera = ViewSpec { size: [320, 240], ..ViewSpec::default() }.camera(&scene.bounds).unwrap();
        let options = Options::default();
        let frame = Renderer::new(&scene).render(&camera, &options).unwrap();
        let report = |samples, most_bytes| {
            let sampling = Sampling { samples, seed: 1 };
            let pixels = |x, y| frame.pixel(x, y);
            let report = judge_in_batches(&scene, &camera, &options, &pixels, &sampling, &|_, _| {}, most_bytes);
            let text = serde_json::to_value(Report { seconds: 0.0, ..report.clone() }).unwrap();
            (text, report)
        };
        for samples in [None, Some(20_000)] {
            let [(kept, a), (forgotten, b)] = [usize::MAX, 0].map(|most_bytes| report(samples, most_bytes));
            assert_eq!(kept, forgotten);
            assert!(a.drawn > 5_000 && a.map == b.map, "{kept}");
        }
    }

    #[test]
    fn what_an_oracle_holds_is_counted_and_dropped() {
        let model = crate::import::load("builtin:trimmed:gap").unwrap();
        let scene = prepare(&model, &|_, _| {}).unwrap();
        let camera = ViewSpec { size: [64, 48], ..ViewSpec::default() }.camera(&scene.bounds).unwrap();
        let mut oracle = Oracle::new(&scene, &camera);
        assert_eq!(oracle.bytes(), 0);
        let hits = oracle.hits(32.0, 24.0);
        let held = oracle.bytes();
        assert!(held > 0 && !hits.is_empty());
        oracle.forget();
        assert_eq!(oracle.bytes(), 0);
        assert_eq!((oracle.hits(32.0, 24.0), oracle.bytes()), (hits, held));
    }
}
