//! One measured run: what was asked for, on what machine, how long it took and how far off it was.

use crate::stages::{Bound, Fill, FrameShape, Grid, Options, Precision, Stats, Trim};
use crate::verify::{ErrorStats, Report};
use serde::{Deserialize, Serialize};

/// One measured run. Every row has both, time and error, or says why it has not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub model: String,
    pub shot: Shot,
    pub setting: Setting,
    pub outcome: Outcome,
    /// What really drew, as every output names it: `cpu`, `software`.
    pub backend: String,
    pub raster: String,
    /// On a device.
    #[serde(default)]
    pub frame: Option<FrameShape>,
    pub machine: super::Machine,
}

/// Where the camera stood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shot {
    /// A named view, or what else describes the camera.
    pub view: String,
    pub zoom: f64,
    pub orthographic: bool,
    pub size: [u32; 2],
}

/// The options that were really used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    pub bound: Bound,
    pub grid: Grid,
    pub fill: Fill,
    #[serde(default)]
    pub trim: Trim,
    #[serde(default)]
    pub precision: Precision,
    pub refine: u32,
    /// Pixels.
    pub tolerance: f64,
    /// Pixel sizes.
    pub depth_tolerance: f64,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    Measured(Box<Measured>),
    /// The frame declined, with its reason (`slefe` on rational surfaces, a grid that needs too much memory).
    Refused(String),
}

/// Figures of a run that drew.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Timed frames; the warm-up frame is not among them.
    pub frames: usize,
    /// Wall clock of the whole frame.
    pub total: Spread,
    /// One entry a stage, in the order in which they ran.
    pub stages: Vec<StageSpread>,
    pub counts: Counts,
    /// `None` where the oracle was not asked.
    pub errors: Option<Errors>,
}

/// A set of times in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    pub median: f64,
    pub min: f64,
    pub max: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageSpread {
    pub stage: String,
    pub ms: Spread,
}

/// What the frame counted; see [`Stats`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    pub patches: u64,
    pub patches_visible: u64,
    pub leaves: u64,
    pub meshlets: u64,
    pub quads: u64,
    pub triangles: u64,
    /// Those of them that Vulkan's mesh shaders were given.
    #[serde(default)]
    pub triangles_hardware: u64,
    /// Copied between what draws the frame and Vulkan's device.
    #[serde(default)]
    pub bytes_copied: u64,
    pub filled: u64,
    pub drawn: u64,
    pub buffer_bytes: u64,
}

/// What the oracle found (DESIGN section 6).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Pixels it looked at, background included.
    pub checked: u64,
    /// `None` where nothing is drawn.
    pub grid: Option<Summary>,
    pub parametric: Option<Summary>,
    pub refined: Option<Summary>,
    pub violations: u64,
    pub cracks: u64,
    pub covering_failures: u64,
    pub depth_failures: u64,
}

/// A distribution of errors in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    pub max: f64,
    pub p999: f64,
    pub mean: f64,
}

impl Row {
    /// The figures, unless the run was refused.
    pub fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            Outcome::Measured(measured) => Some(measured),
            Outcome::Refused(_) => None,
        }
    }

    /// What the oracle found, where it was asked.
    pub fn errors(&self) -> Option<&Errors> {
        self.measured()?.errors.as_ref()
    }
}

impl Shot {
    pub fn projection(&self) -> &'static str {
        if self.orthographic { "orthographic" } else { "perspective" }
    }
}

impl Measured {
    /// Median milliseconds of one stage; 0 where no such stage ran.
    pub fn stage(&self, name: &str) -> f64 {
        self.stages.iter().find(|s| s.stage == name).map_or(0.0, |s| s.ms.median)
    }
}

impl Errors {
    /// Everything that breaks the accuracy contract.
    pub fn broken(&self) -> u64 {
        self.violations + self.cracks + self.covering_failures + self.depth_failures
    }

    /// Largest error of the interpolated parameter: what a tessellation bound must keep.
    pub fn grid_max(&self) -> Option<f64> {
        self.grid.map(|s| s.max)
    }
}

impl Spread {
    /// Median, least and largest of `times`; zeros for none. The median of an even number is the mean of the middle two.
    pub fn of(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        let (Some(&min), Some(&max)) = (times.first(), times.last()) else { return Self::default() };
        let half = times.len() / 2;
        let median = if times.len() % 2 == 1 { times[half] } else { (times[half - 1] + times[half]) / 2.0 };
        Self { median, min, max }
    }
}

impl From<&Options> for Setting {
    fn from(o: &Options) -> Self {
        Self {
            bound: o.bound,
            grid: o.grid,
            fill: o.fill,
            trim: o.trim,
            precision: o.precision,
            refine: o.refine,
            tolerance: o.tolerance,
            depth_tolerance: o.depth_tolerance,
        }
    }
}

impl From<&Stats> for Counts {
    fn from(s: &Stats) -> Self {
        Self {
            patches: s.patches,
            patches_visible: s.patches_visible,
            leaves: s.leaves,
            meshlets: s.meshlets,
            quads: s.quads,
            triangles: s.triangles,
            triangles_hardware: s.triangles_hardware,
            bytes_copied: s.bytes_copied,
            filled: s.filled,
            drawn: s.drawn,
            buffer_bytes: s.buffer_bytes,
        }
    }
}

impl From<&Report> for Errors {
    fn from(r: &Report) -> Self {
        let summary = |stats: Option<ErrorStats>| stats.map(|s| Summary { max: s.max, p999: s.p999, mean: s.mean });
        Self {
            checked: r.pixels,
            grid: summary(r.grid_error_px),
            parametric: summary(r.parametric_error_px),
            refined: summary(r.refined_error_px),
            violations: r.violations,
            cracks: r.cracks,
            covering_failures: r.covering_failures,
            depth_failures: r.depth_failures,
        }
    }
}

/// Per stage the spread over several frames' statistics; a stage that some frames lack counts where it ran.
pub fn stage_spreads(frames: &[Stats]) -> Vec<StageSpread> {
    let mut names: Vec<&str> = Vec::new();
    for time in frames.iter().flat_map(|f| &f.stages) {
        if !names.contains(&time.stage) {
            names.push(time.stage);
        }
    }
    let times = |name| frames.iter().flat_map(|f| &f.stages).filter(|t| t.stage == name).map(|t| t.ms).collect();
    names.iter().map(|&name| StageSpread { stage: name.into(), ms: Spread::of(times(name)) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::StageTime;

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_two() {
        assert_eq!(Spread::of(vec![4.0, 1.0, 2.0, 9.0]), Spread { median: 3.0, min: 1.0, max: 9.0 });
        assert_eq!(Spread::of(vec![5.0, 1.0, 2.0]).median, 2.0);
        assert_eq!(Spread::of(vec![]), Spread::default());
    }

    #[test]
    fn stages_keep_the_order_in_which_they_ran() {
        let frame = |a, b| Stats {
            stages: vec![StageTime { stage: "shade", ms: a }, StageTime { stage: "cull", ms: b }],
            ..Stats::default()
        };
        let spreads = stage_spreads(&[frame(1.0, 5.0), frame(3.0, 5.0), frame(2.0, 8.0)]);
        assert_eq!(spreads.iter().map(|s| s.stage.as_str()).collect::<Vec<_>>(), ["shade", "cull"]);
        assert_eq!(spreads[0].ms, Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(spreads[1].ms.median, 5.0);
    }
}
