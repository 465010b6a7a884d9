//! One measured run: frames against the clock, then one of them before the oracle.

use crate::report::{Counts, Errors, Machine, Measured, Outcome, Row, Setting, Shot, Spread, name, stage_spreads};
use crate::scene::{Scene, ViewSpec};
use crate::stages::{Frame, Options, RenderError, Renderer, Stats};
use crate::verify::{Sampling, verify};
use anyhow::Result;
use std::time::Instant;

/// How thoroughly to measure.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Effort {
    /// Timed frames a run, after one that warms up
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// Pixels the oracle checks a run, drawn at random; as many again near borders; 0 for none
    #[arg(long, value_name = "N", default_value_t = 2_000)]
    pub samples: usize,
    /// Seed of the random choice
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// A prepared model to be measured.
#[derive(Debug)]
pub struct Subject<'a> {
    pub model: &'a str,
    pub scene: &'a Scene,
    pub effort: Effort,
    machine: Machine,
    /// Keeps its buffers from run to run.
    renderer: Renderer<'a>,
}

/// Frames of one run: what each counted and took, and the last one itself.
pub struct Timed {
    pub stats: Vec<Stats>,
    /// Wall clock of each whole frame in milliseconds.
    pub total: Vec<f64>,
    pub frame: Frame,
}

impl<'a> Subject<'a> {
    pub fn new(model: &'a str, scene: &'a Scene, effort: Effort) -> Self {
        let machine = Machine::here(rayon::current_num_threads());
        Self { model, scene, effort, machine, renderer: Renderer::new(scene) }
    }

    /// Measures one configuration. A frame that is declined is a row with the reason, not a failure.
    pub fn row(&mut self, view: &ViewSpec, options: &Options) -> Result<Row> {
        let outcome = match self.time(view, options)? {
            Ok(timed) => {
                let errors = judge(self.scene, &timed.frame, self.effort);
                let measured = timed.measured(errors);
                self.renderer.recycle(timed.frame);
                Outcome::Measured(Box::new(measured))
            }
            Err(refused) => Outcome::Refused(refused.to_string()),
        };
        Ok(self.labelled(view, options, outcome))
    }

    /// The row of a finished run.
    pub fn labelled(&self, view: &ViewSpec, options: &Options, outcome: Outcome) -> Row {
        Row {
            model: self.model.into(),
            shot: shot(view),
            setting: Setting::from(options),
            outcome,
            machine: self.machine.clone(),
        }
    }

    /// Draws a frame to warm up, then the timed ones.
    pub fn time(&mut self, view: &ViewSpec, options: &Options) -> Result<Result<Timed, RenderError>> {
        let camera = view.camera(&self.scene.bounds)?;
        let (mut stats, mut total) = (Vec::new(), Vec::new());
        let mut frame = match self.renderer.render(&camera, options) {
            Ok(frame) => frame,
            Err(refused) => return Ok(Err(refused)),
        };
        for _ in 0..self.effort.frames {
            self.renderer.recycle(frame);
            let start = Instant::now();
            frame = match self.renderer.render(&camera, options) {
                Ok(frame) => frame,
                Err(refused) => return Ok(Err(refused)),
            };
            total.push(start.elapsed().as_secs_f64() * 1e3);
            stats.push(frame.stats.clone());
        }
        Ok(Ok(Timed { stats, total, frame }))
    }
}

impl Timed {
    pub fn measured(&self, errors: Option<Errors>) -> Measured {
        Measured {
            frames: self.total.len(),
            total: Spread::of(self.total.clone()),
            stages: stage_spreads(&self.stats),
            counts: Counts::from(&self.frame.stats),
            errors,
        }
    }
}

/// What a camera is called in tables: the named view, or the eye's place.
pub fn shot(view: &ViewSpec) -> Shot {
    let called = match view.eye {
        Some(eye) => format!("eye {},{},{}", eye.x, eye.y, eye.z),
        None => name(view.view),
    };
    Shot { view: called, zoom: view.zoom, orthographic: view.orthographic, size: view.size }
}

/// Asks the oracle about a frame; `None` where the effort holds no samples.
pub fn judge(scene: &Scene, frame: &Frame, effort: Effort) -> Option<Errors> {
    if effort.samples == 0 {
        return None;
    }
    let sampling = Sampling { samples: Some(effort.samples), seed: effort.seed };
    let pixels = |x, y| frame.pixel(x, y);
    Some(Errors::from(&verify(scene, &frame.camera, &frame.options, &pixels, &sampling, &|_, _| ())))
}
