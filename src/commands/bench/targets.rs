//! What a GPU must reach, beside what was found. Nothing is concluded from another device or another scene.

use crate::cuda::precision::Arithmetic;
use crate::report::{Errors, Row, Summary, Table};
use crate::stages::{Bound, CONVERGED, FrameShape, Grid, Precision, Trim};

/// A target, and whether what was found reaches it.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    pub target: &'static str,
    pub wanted: String,
    pub found: String,
    pub judgement: Judgement,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judgement {
    Holds,
    Fails,
    /// The target names another device, or another scene.
    Pending,
}

/// Time over that of storing the same bytes.
const STORES: f64 = 1.3;
/// The scene that must be drawn in so many milliseconds, and which others are like it.
const PATCHES: u64 = 3_700_000;
const CULLED: [f64; 2] = [0.4, 0.6];
const QUADS: [f64; 2] = [2.0, 3.0];
const MILLISECONDS: f64 = 2.0;
const DEVICE: &str = "H100";
/// How much faster than ETER's configuration; scenes are large from as many surfaces as its Lego has.
const FASTER: f64 = 5.0;
const LARGE: u64 = 300_000;
/// Pixels before refinement.
const HALF_PIXEL: f64 = 0.5;

impl Judgement {
    fn of(holds: bool) -> Self {
        if holds { Self::Holds } else { Self::Fails }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Pending => "pending",
        }
    }
}

/// Verdicts as people and machines read them.
pub fn table(verdicts: &[Verdict]) -> Table {
    let mut table = Table::new(&["target", "wanted", "found", "verdict"]);
    for Verdict { target, wanted, found, judgement } in verdicts {
        table.push(vec![(*target).into(), wanted.as_str().into(), found.as_str().into(), judgement.name().into()]);
    }
    table
}

/// Kernels that evaluate vertices of frames in single precision, each with its degree and its time over the store floor: the
/// fastest of a degree counts, and the degree that is worst. `real`: times are a GPU's.
pub fn evaluation(times: &[(u8, Arithmetic, f64)], real: bool) -> Verdict {
    let single = |a: Arithmetic| matches!(a, Arithmetic::F32 | Arithmetic::F16Recovered | Arithmetic::Tf32Recovered);
    let mut degrees: Vec<u8> = times.iter().map(|t| t.0).collect();
    degrees.dedup();
    let best = |&degree: &u8| {
        let all = times.iter().filter(|t| t.0 == degree && single(t.1));
        all.min_by(|a, b| a.2.total_cmp(&b.2))
    };
    let worst = degrees.iter().filter_map(best).max_by(|a, b| a.2.total_cmp(&b.2));
    let (found, judgement) = match worst {
        Some((degree, arithmetic, ratio)) if real => {
            (format!("{ratio:.2} (degree {degree}, {arithmetic:?})"), Judgement::of(*ratio <= STORES))
        }
        _ => ("no GPU ran".into(), Judgement::Pending),
    };
    let wanted = format!("at most {STORES} times the store floor");
    Verdict { target: "staged evaluation", wanted, found, judgement }
}

/// A fused frame and ETER's configuration of the same scene, measured by turns.
#[derive(Clone, Copy)]
struct Pair<'a> {
    fused: &'a Row,
    eter: &'a Row,
}

/// Verdicts on the largest scene among rows of `bench frame`. `plain`: all its patches are bicubic polynomials without trims.
pub fn frame(rows: &[Row], trim: Trim, plain: bool) -> Vec<Verdict> {
    let fused = || rows.iter().filter(|row| row.frame == Some(FrameShape::Fused) && drawn(row, trim));
    let pairs = fused().filter_map(|fused| Pair::of(fused, rows, trim));
    let pair = pairs.reduce(|a, b| if b.patches() > a.patches() { b } else { a });
    // The first of a scene is the one that was asked for.
    let largest = fused().reduce(|a, b| if patches(b) > patches(a) { b } else { a });
    let none = || ("no kernels drew it".into(), Judgement::Pending);
    let of = |target, wanted, judge: &dyn Fn(Pair) -> (String, Judgement)| {
        let (found, judgement) = pair.map_or_else(none, judge);
        Verdict { target, wanted, found, judgement }
    };
    let (found, judgement) = largest.map_or_else(none, |row| time(row, plain));
    let scene = format!("{:.1} million bicubic patches, half culled, 2.5 quads each, untrimmed", PATCHES as f64 * 1e-6);
    vec![
        Verdict {
            target: "large frame",
            wanted: format!("{scene}: at most {MILLISECONDS} ms on an {DEVICE}"),
            found,
            judgement,
        },
        of("fused against staged ETER", format!("at least {FASTER} times faster on a large scene"), &|p| p.faster()),
        of("error before refinement", format!("both at most {HALF_PIXEL} px on a large scene"), &|p| p.before()),
        of(
            "error after refinement",
            format!("at most ETER's and the {CONVERGED:.5} px that refinement may leave"),
            &|p| p.after(),
        ),
    ]
}

fn drawn(row: &Row, trim: Trim) -> bool {
    row.measured().is_some() && row.setting.trim == trim
}

fn patches(row: &Row) -> u64 {
    row.measured().map_or(0, |m| m.counts.patches)
}

fn is_cuda(row: &Row) -> bool {
    row.backend == "cuda"
}

fn device(row: &Row) -> &str {
    if is_cuda(row) { &row.machine.device } else { "the CPU in place of a GPU" }
}

/// Milliseconds of the device's own clock: transfers and the host are no part of them, as in ETER's tables. `None`: it was not
/// asked.
fn device_ms(row: &Row) -> Option<f64> {
    let all: f64 = row.measured()?.stages.iter().map(|stage| stage.ms.median).sum();
    (all > 0.0).then_some(all)
}

fn unknown() -> (String, Judgement) {
    ("not measured".into(), Judgement::Pending)
}

fn time(row: &Row, plain: bool) -> (String, Judgement) {
    let Some((m, ms)) = row.measured().zip(device_ms(row)) else { return unknown() };
    let c = &m.counts;
    let culled = 1.0 - c.patches_visible as f64 / c.patches.max(1) as f64;
    let quads = c.quads as f64 / c.patches_visible.max(1) as f64;
    let within = |x: f64, [low, high]: [f64; 2]| low <= x && x <= high;
    let same = plain && c.patches >= PATCHES && within(culled, CULLED) && within(quads, QUADS);
    let scene = format!("{} patches, {:.0} % culled, {quads:.2} quads each", c.patches, 100.0 * culled);
    if !(same && is_cuda(row) && row.machine.device.contains(DEVICE)) {
        let kind = if plain { "" } else { ", not all bicubic and untrimmed" };
        return (format!("{scene}{kind}, on {}", device(row)), Judgement::Pending);
    }
    let text = format!("{ms:.2} ms on the device, {:.2} ms with transfers and the host; {scene}", m.total.median);
    (text, Judgement::of(ms <= MILLISECONDS))
}

impl<'a> Pair<'a> {
    fn of(fused: &'a Row, rows: &'a [Row], trim: Trim) -> Option<Self> {
        let is_eter = |row: &&Row| {
            let s = &row.setting;
            let own = s.bound == Bound::Eter && s.grid == Grid::Eter && s.precision == Precision::F16Recovered;
            own && row.frame == Some(FrameShape::Staged) && row.model == fused.model && drawn(row, trim)
        };
        Some(Self { fused, eter: rows.iter().find(is_eter)? })
    }

    fn patches(&self) -> u64 {
        patches(self.fused)
    }

    fn faster(self) -> (String, Judgement) {
        let ms = device_ms(self.fused).zip(device_ms(self.eter));
        let Some((ours, eter)) = ms else { return unknown() };
        if !is_cuda(self.fused) || self.patches() < LARGE {
            return (format!("{} patches on {}", self.patches(), device(self.fused)), Judgement::Pending);
        }
        let ratio = eter / ours;
        let total = |row: &Row| row.measured().map_or(f64::NAN, |m| m.total.median);
        let all = total(self.eter) / total(self.fused);
        let text = format!("{ratio:.2} times on the device, {all:.2} with the rest; {} patches", self.patches());
        (text, Judgement::of(ratio >= FASTER))
    }

    fn before(self) -> (String, Judgement) {
        self.errors(|e| e.grid, |ours, eter| ours.max(eter) <= HALF_PIXEL)
    }

    fn after(self) -> (String, Judgement) {
        self.errors(|e| e.refined, |ours, eter| ours <= eter + f64::from(CONVERGED))
    }

    /// Errors are the same on every device that runs the kernels.
    fn errors(self, get: fn(&Errors) -> Option<Summary>, holds: impl Fn(f64, f64) -> bool) -> (String, Judgement) {
        let max = |row: &Row| row.errors().and_then(get).map(|summary| summary.max);
        let Some((ours, eter)) = max(self.fused).zip(max(self.eter)) else { return unknown() };
        let judgement = if self.patches() < LARGE { Judgement::Pending } else { Judgement::of(holds(ours, eter)) };
        (format!("{ours:.5} px, ETER's {eter:.5} px; {} patches", self.patches()), judgement)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Counts, Measured, Outcome, testing};

    /// A frame on a device: its time by the clock of the device is a tenth of `ms`.
    fn row(frame: FrameShape, device: &str, ms: f64, errors: [f64; 2]) -> Row {
        let (bound, grid, precision) = match frame {
            FrameShape::Fused => (Bound::Screen, Grid::Adaptive, Precision::F32),
            FrameShape::Staged => (Bound::Eter, Grid::Eter, Precision::F16Recovered),
        };
        let mut row = testing::row(bound, grid, 0.5, ms, 0.1);
        row.setting.precision = precision;
        (row.frame, row.backend, row.machine.device) = (Some(frame), "cuda".into(), device.into());
        if let Outcome::Measured(m) = &mut row.outcome {
            m.counts =
                Counts { patches: PATCHES, patches_visible: PATCHES / 2, quads: PATCHES * 5 / 4, ..Counts::default() };
            let [grid, refined] = errors.map(|max| Some(Summary { max, ..Summary::default() }));
            m.errors = Some(Errors { grid, refined, ..Errors::default() });
        }
        row
    }

    fn rows(device: &str, [ours, eter]: [f64; 2], errors: [[f64; 2]; 2]) -> Vec<Row> {
        vec![row(FrameShape::Fused, device, ours, errors[0]), row(FrameShape::Staged, device, eter, errors[1])]
    }

    fn with(mut rows: Vec<Row>, change: impl Fn(&mut Measured)) -> Vec<Row> {
        for row in &mut rows {
            if let Outcome::Measured(m) = &mut row.outcome {
                change(m);
            }
        }
        rows
    }

    fn judged(rows: &[Row], plain: bool) -> Vec<Judgement> {
        frame(rows, Trim::default(), plain).into_iter().map(|v| v.judgement).collect()
    }

    const GOOD: [[f64; 2]; 2] = [[0.41, 0.00192], [0.38, 0.00189]];
    use Judgement::{Fails, Holds, Pending};

    #[test]
    fn targets_hold_or_fail_on_the_device_that_they_name() {
        let device = "NVIDIA H100 80GB HBM3, driver 999";
        assert_eq!(judged(&rows(device, [19.0, 95.0], GOOD), true), [Holds; 4]);
        let bad = [[0.41, 0.0040], [0.51, 0.0019]];
        assert_eq!(judged(&rows(device, [21.0, 104.0], bad), true), [Fails; 4]);
        // What refinement leaves is no difference.
        let left = f64::from(CONVERGED);
        let equal = [[0.1, 0.0019 + 0.99 * left], [0.1, 0.0019]];
        assert_eq!(judged(&rows(device, [19.0, 95.0], equal), true)[3], Holds);
    }

    #[test]
    fn other_devices_and_scenes_leave_targets_pending() {
        let times = [19.0, 95.0];
        assert_eq!(judged(&rows("NVIDIA A100", times, GOOD), true), [Pending, Holds, Holds, Holds]);
        assert_eq!(judged(&rows("NVIDIA H100", times, GOOD), false), [Pending, Holds, Holds, Holds]);
        let mut emulated = rows("a processor", times, GOOD);
        emulated.iter_mut().for_each(|row| row.backend = "emulated".into());
        assert_eq!(judged(&emulated, true), [Pending, Pending, Holds, Holds]);
        for change in [
            |c: &mut Counts| c.patches -= 1,
            |c: &mut Counts| c.quads *= 3,
            |c: &mut Counts| c.patches_visible = c.patches,
        ] {
            let other = with(rows("NVIDIA H100", times, GOOD), |m| change(&mut m.counts));
            assert_eq!(judged(&other, true), [Pending, Holds, Holds, Holds]);
        }
        let small = with(rows("NVIDIA H100", times, GOOD), |m| m.counts.patches = LARGE - 1);
        assert_eq!(judged(&small, true), [Pending; 4]);
        let cpu = [testing::row(Bound::Screen, Grid::Adaptive, 0.5, 1.0, 0.1)];
        assert_eq!(judged(&cpu, true), [Pending; 4]);
        // A target for ours alone needs nothing of ETER's.
        assert_eq!(judged(&rows("NVIDIA H100", times, GOOD)[..1], true), [Holds, Pending, Pending, Pending]);
        let untimed = with(rows("NVIDIA H100", times, GOOD), |m| m.stages.clear());
        assert_eq!(judged(&untimed, true), [Pending, Pending, Holds, Holds]);
        let unasked = with(rows("NVIDIA H100", times, GOOD), |m| m.errors = None);
        assert_eq!(judged(&unasked, true), [Holds, Holds, Pending, Pending]);
    }

    #[test]
    fn the_largest_scene_counts() {
        let mut all = with(rows("NVIDIA H100", [19.0, 20.0], GOOD), |m| m.counts.patches = LARGE);
        all.iter_mut().for_each(|row| row.model = "one".into());
        assert_eq!(judged(&all, true)[..2], [Pending, Fails]);
        all.extend(rows("NVIDIA H100", [19.0, 95.0], GOOD));
        assert_eq!(judged(&all, true), [Holds; 4]);
    }

    #[test]
    fn the_fastest_kernel_of_the_worst_degree_is_near_the_store_floor() {
        use Arithmetic::{F16, F16Recovered, F32};
        let times = [(3, F32, 1.25), (3, F16, 1.0), (7, F16, 1.0), (7, F32, 2.0), (7, F16Recovered, 1.29)];
        let verdict = evaluation(&times, true);
        assert_eq!((verdict.judgement, verdict.found.as_str()), (Holds, "1.29 (degree 7, F16Recovered)"));
        // Plain f16 is not single precision.
        assert_eq!(evaluation(&times[..4], true).judgement, Fails);
        assert_eq!(evaluation(&times, false).judgement, Pending);
        assert_eq!(evaluation(&[], true).judgement, Pending);
    }

    #[test]
    fn verdicts_are_words() {
        let verdicts = frame(&rows("NVIDIA A100", [19.0, 30.0], GOOD), Trim::default(), true);
        let text = table(&verdicts).markdown();
        assert!(text.contains("1.58 times on the device") && text.contains("at most 2 ms on an H100"), "{text}");
        let words: Vec<_> = verdicts.iter().map(|v| v.judgement.name()).collect();
        assert_eq!(words, ["pending", "does not hold", "holds", "holds"]);
    }
}
