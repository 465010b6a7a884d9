//! One measured run: frames against the clock, then one of them before the oracle.

use super::used::Used;
use crate::report::{Counts, Errors, Machine, Measured, Outcome, Row, Setting, Shot, Spread, name, stage_spreads};
use crate::scene::{Camera, Scene, ViewSpec};
use crate::stages::{Engine, Frame, Options, RenderError, Renderer, Stats};
use crate::verify::{Sampling, verify};
use anyhow::Result;
use std::path::Path;
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
    /// As rows call it: a file by its name alone, wherever it lies.
    pub model: String,
    scene: &'a Scene,
    effort: Effort,
    machine: Machine,
    /// Keeps its buffers from run to run.
    renderer: Renderer<'a>,
}

/// Frames of one run: what each counted and took, and the last one itself.
#[derive(Debug)]
pub struct Timed {
    pub stats: Vec<Stats>,
    /// Wall clock of each whole frame in milliseconds.
    pub total: Vec<f64>,
    pub frame: Frame,
}

impl<'a> Subject<'a> {
    pub fn new(model: &str, scene: &'a Scene, effort: Effort, engine: Engine) -> Self {
        let name = Path::new(model).file_name().map_or(model.into(), |name| name.to_string_lossy());
        let mut machine = Machine::here(rayon::current_num_threads());
        if let Some(gpu) = engine.gpu() {
            machine.device = gpu;
        }
        Self { model: name.into_owned(), scene, effort, machine, renderer: Renderer::with(scene, engine) }
    }

    /// Measures one configuration. A frame that is declined is a row with the reason, not a failure.
    pub fn row(&mut self, view: &ViewSpec, options: &Options) -> Result<Row> {
        Ok(self.rows(view, std::slice::from_ref(options))?.remove(0))
    }

    /// Measures several configurations by turns, a frame each, so that what else the machine does meets all alike.
    pub fn rows(&mut self, view: &ViewSpec, options: &[Options]) -> Result<Vec<Row>> {
        let camera = view.camera(&self.scene.bounds)?;
        let mut runs: Vec<Run> = options.iter().map(|_| Run::default()).collect();
        for turn in 0..=self.effort.frames {
            for (run, options) in runs.iter_mut().zip(options) {
                run.draw(&mut self.renderer, &camera, options, turn == 0);
            }
        }
        let mut rows = Vec::new();
        for (run, options) in runs.into_iter().zip(options) {
            let outcome = match self.finish(run, &camera, options) {
                Ok(timed) => {
                    let errors = judge(self.scene, &timed.frame, self.effort);
                    let measured = timed.measured(errors);
                    self.renderer.recycle(timed.frame);
                    Outcome::Measured(Box::new(measured))
                }
                Err(refused) => Outcome::Refused(refused.to_string()),
            };
            rows.push(self.labelled(view, options, outcome));
        }
        Ok(rows)
    }

    /// Draws a frame to warm up, then the timed ones.
    pub fn time(&mut self, view: &ViewSpec, options: &Options) -> Result<Result<Timed, RenderError>> {
        let camera = view.camera(&self.scene.bounds)?;
        let mut run = Run::default();
        for turn in 0..=self.effort.frames {
            run.draw(&mut self.renderer, &camera, options, turn == 0);
        }
        Ok(self.finish(run, &camera, options))
    }

    /// The row of a finished run.
    pub fn labelled(&self, view: &ViewSpec, options: &Options, outcome: Outcome) -> Row {
        let used = Used::by(options, &self.renderer);
        Row {
            model: self.model.clone(),
            shot: shot(view),
            setting: Setting::from(options),
            outcome,
            backend: used.backend.into(),
            raster: used.raster.into(),
            frame: used.frame,
            machine: self.machine.clone(),
        }
    }

    /// Draws the frame once more for the oracle: the same input gives the same words.
    fn finish(&mut self, run: Run, camera: &Camera, options: &Options) -> Result<Timed, RenderError> {
        if let Some(refused) = run.refused {
            return Err(refused);
        }
        let frame = self.renderer.render(camera, options)?;
        Ok(Timed { stats: run.stats, total: run.total, frame })
    }
}

/// Frames of one configuration so far.
#[derive(Debug, Default)]
pub struct Run {
    pub stats: Vec<Stats>,
    pub total: Vec<f64>,
    pub refused: Option<RenderError>,
}

impl Run {
    /// Draws a frame, unless one was refused before; a frame that warms up is not counted.
    pub fn draw(&mut self, renderer: &mut Renderer<'_>, camera: &Camera, options: &Options, warm_up: bool) {
        if self.refused.is_some() {
            return;
        }
        let start = Instant::now();
        let frame = match renderer.render(camera, options) {
            Ok(frame) => frame,
            Err(refused) => {
                self.refused = Some(refused);
                return;
            }
        };
        if !warm_up {
            self.total.push(start.elapsed().as_secs_f64() * 1e3);
            self.stats.push(frame.stats.clone());
        }
        renderer.recycle(frame);
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
