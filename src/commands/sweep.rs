//! Lists of what varies from run to run, for `compare` and `bench`.

use super::args::{FrameArgs, ProjectionKind, parse_tolerance, parse_zoom};
use super::{UsageError, measure::Effort};
use crate::scene::{View, ViewSpec};
use crate::stages::{Bound, Grid, Options, Trim};
use anyhow::Result;

/// What to vary.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct SweepArgs {
    /// Bounds to run
    #[arg(long, value_enum, value_delimiter = ',', value_name = "BOUND,...")]
    pub bounds: Vec<Bound>,
    /// Grids to run
    #[arg(long, value_enum, value_delimiter = ',', value_name = "GRID,...")]
    pub grids: Vec<Grid>,
    /// Ways to trim to run
    #[arg(long, value_enum, value_delimiter = ',', value_name = "TRIM,...")]
    pub trims: Vec<Trim>,
    /// Tolerances to run, in pixels
    #[arg(long, value_delimiter = ',', value_name = "PIXELS,...", value_parser = parse_tolerance)]
    pub tolerances: Vec<f64>,
    /// Views to run
    #[arg(long, value_enum, value_delimiter = ',', value_name = "VIEW,...")]
    pub views: Vec<View>,
    /// Magnifications to run
    #[arg(long, value_delimiter = ',', value_name = "FACTOR,...", value_parser = parse_zoom)]
    pub zooms: Vec<f64>,
    /// Projections to run
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PROJECTION,...")]
    pub projections: Vec<ProjectionKind>,
}

/// What a list holds where neither it nor the option of the same name says otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Usual {
    pub bounds: &'static [Bound],
    pub grids: &'static [Grid],
    pub tolerances: &'static [f64],
    pub views: &'static [View],
    pub zooms: &'static [f64],
    pub projections: &'static [ProjectionKind],
}

/// Every combination that is to be run.
#[derive(Clone, Debug)]
pub struct Sweep {
    pub shots: Vec<ViewSpec>,
    pub options: Vec<Options>,
}

impl SweepArgs {
    /// The combinations: a list, else the option of the same name where it was changed, else what is usual.
    pub fn resolve(&self, frame: &FrameArgs, usual: &Usual) -> Result<Sweep> {
        if frame.eye.is_some() && !self.views.is_empty() {
            return Err(UsageError("--eye replaces the named views: leave out --views or --eye".into()).into());
        }
        Ok(Sweep { shots: self.shots(frame, usual), options: self.options(frame, usual) })
    }

    fn shots(&self, frame: &FrameArgs, usual: &Usual) -> Vec<ViewSpec> {
        let spec = frame.view_spec();
        let views = match spec.eye {
            Some(_) => vec![spec.view],
            None => list(&self.views, spec.view, View::default(), usual.views),
        };
        let zooms = list(&self.zooms, spec.zoom, 1.0, usual.zooms);
        let projections = list(&self.projections, frame.projection, ProjectionKind::default(), usual.projections);
        let mut shots = Vec::new();
        for &projection in &projections {
            let orthographic = projection == ProjectionKind::Orthographic;
            for &view in &views {
                shots.extend(zooms.iter().map(|&zoom| ViewSpec { view, zoom, orthographic, ..spec }));
            }
        }
        shots
    }

    fn options(&self, frame: &FrameArgs, usual: &Usual) -> Vec<Options> {
        let (asked, default) = (frame.options(), Options::default());
        let bounds = list(&self.bounds, asked.bound, default.bound, usual.bounds);
        let grids = list(&self.grids, asked.grid, default.grid, usual.grids);
        let tolerances = list(&self.tolerances, asked.tolerance, default.tolerance, usual.tolerances);
        let trims = list(&self.trims, asked.trim, default.trim, &[Trim::On]);
        let mut options = Vec::new();
        for &bound in &bounds {
            for &grid in &grids {
                for &trim in &trims {
                    options.extend(tolerances.iter().map(|&tolerance| Options {
                        bound,
                        grid,
                        trim,
                        tolerance,
                        ..asked
                    }));
                }
            }
        }
        options
    }
}

impl Sweep {
    pub fn len(&self) -> usize {
        self.shots.len() * self.options.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Quick runs for counting: one frame, no oracle.
pub const COUNT_ONLY: Effort = Effort { frames: 1, samples: 0, seed: 0 };

fn list<T: Copy + PartialEq>(list: &[T], single: T, default: T, usual: &[T]) -> Vec<T> {
    match (list, single != default) {
        ([], true) => vec![single],
        ([], false) => usual.to_vec(),
        (list, _) => list.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        frame: FrameArgs,
        #[command(flatten)]
        sweep: SweepArgs,
    }

    const USUAL: Usual = Usual {
        bounds: &[Bound::Screen, Bound::Eter],
        grids: &[Grid::Adaptive],
        tolerances: &[0.5],
        views: &[View::Iso, View::Front, View::Top],
        zooms: &[1.0, 8.0],
        projections: &[ProjectionKind::Perspective],
    };

    fn sweep(arguments: &str) -> Result<Sweep> {
        let line = Line::try_parse_from(["halfpixel", "model"].into_iter().chain(arguments.split_whitespace()))?;
        line.sweep.resolve(&line.frame, &USUAL)
    }

    #[test]
    fn lists_options_and_what_is_usual() {
        let usual = sweep("").unwrap();
        assert_eq!((usual.shots.len(), usual.options.len(), usual.len()), (6, 2, 12));
        let some = sweep("--bounds filip,slefe --zoom 3 --views left --projection orthographic").unwrap();
        assert_eq!(some.options.iter().map(|o| o.bound).collect::<Vec<_>>(), [Bound::Filip, Bound::Slefe]);
        assert_eq!(some.shots.len(), 1);
        assert!(some.shots[0].zoom == 3.0 && some.shots[0].view == View::Left && some.shots[0].orthographic);
    }

    #[test]
    fn an_eye_is_one_view() {
        assert_eq!(sweep("--eye 1,2,3").unwrap().shots.len(), 2);
        assert!(sweep("--eye 1,2,3 --views top").is_err());
    }
}
