//! What is read: one file, a list of them, or one part of what they hold.

use super::{UsageError, output};
use crate::import::{self, ImportError};
use crate::model::{Instance, Layout, Model, Warning};
use crate::scene::{Scene, prepare};
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use glam::{DAffine3, DMat3, DVec3};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// What is read, and how.
#[derive(Clone, Debug, clap::Args)]
pub struct ModelArgs {
    /// Files to read (their content decides the format), builtin:NAME, or @FILE for a list of them, one a line
    #[arg(value_name = "MODEL", required = true)]
    pub models: Vec<String>,
    /// Where several files stand
    #[arg(long, value_enum, default_value_t)]
    pub layout: Layout,
    /// Only this part: a name of a part, component, solid or face, or the file's number of one, or of a shell or a set
    #[arg(long, value_name = "NAME|#ID")]
    pub part: Option<String>,
    /// The model's axis that points up; y turns the model so that it becomes z
    #[arg(long, value_enum, default_value_t, value_name = "AXIS")]
    pub up_axis: UpAxis,
    /// Fail where a file can't be read, or where something in it was lost or mended
    #[arg(long)]
    pub strict: bool,
    /// Threads to use [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
          allow_hyphen_values = true)]
    pub threads: Option<u16>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    Y,
    #[default]
    Z,
}

/// What was read; the names are those of the JSON outputs.
#[derive(Debug, Serialize)]
pub struct Loaded {
    /// What to call it.
    #[serde(rename = "model")]
    pub name: String,
    /// Files that were asked for.
    pub files: usize,
    /// Those that could not be read, each with the reason.
    pub unread_files: Vec<String>,
    #[serde(skip)]
    pub model: Model,
}

impl ModelArgs {
    /// Reads the models and turns them upright. What is missing is counted on standard error, or with `--strict` an error.
    pub fn load(&self) -> Result<Loaded> {
        let loaded = self.load_silently()?;
        if let Some(line) = loss_line(&loaded.model) {
            output::warning_line(&format!("{}: {line}; `halfpixel info` lists them", loaded.name));
        }
        Ok(loaded)
    }

    /// As `load`, for a caller that shows warnings and lost faces itself. Files that can't be read are named in any case.
    pub fn load_silently(&self) -> Result<Loaded> {
        let files = self.files()?;
        let mut loaded = match &files[..] {
            [file] => Loaded { name: file.clone(), files: 1, unread_files: Vec::new(), model: load_model(file)? },
            _ => self.load_list(&files)?,
        };
        if let Some(part) = &self.part {
            let model = std::mem::take(&mut loaded.model).select(part);
            loaded.model = model.with_context(|| loaded.name.clone())?;
        }
        if let Some(line) = loss_line(&loaded.model).filter(|_| self.strict) {
            bail!("{}: {line}: leave out --strict to go on without that", loaded.name);
        }
        if self.up_axis == UpAxis::Y {
            // A quarter turn about x takes +y to +z.
            let upright = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y));
            for instance in &mut loaded.model.instances {
                instance.transform = upright * instance.transform;
            }
        }
        Ok(loaded)
    }

    /// Reads and prepares the model, with a progress bar on a terminal.
    pub fn load_scene(&self) -> Result<(Loaded, Scene)> {
        let loaded = self.load()?;
        let scene = prepare_model(&loaded.model).with_context(|| loaded.name.clone())?;
        Ok((loaded, scene))
    }

    /// What the models together are called.
    pub fn label(&self) -> String {
        match &self.models[..] {
            [one] => one.clone(),
            [first, rest @ ..] => format!("{first} and {} more", rest.len()),
            [] => String::new(),
        }
    }

    /// The same arguments for each model alone.
    pub fn each(&self) -> impl Iterator<Item = ModelArgs> {
        self.models.iter().map(|model| ModelArgs { models: vec![model.clone()], ..self.clone() })
    }

    /// Runs `work` on `--threads` threads.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> Result<R> + Send) -> Result<R> {
        let threads = self.threads.map_or(0, usize::from);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.context("could not start the threads asked for: give a smaller --threads")?.install(work)
    }

    /// The files asked for, lists read. Their paths are relative to where the program runs, like all others.
    pub(super) fn files(&self) -> Result<Vec<String>> {
        let mut files = Vec::new();
        for model in &self.models {
            let Some(list) = model.strip_prefix('@') else {
                files.push(model.clone());
                continue;
            };
            let text = std::fs::read_to_string(list).with_context(|| format!("{list}: the list of files"))?;
            let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
            let before = files.len();
            files.extend(lines.map(str::to_owned));
            if files.len() == before {
                bail!("{list}: the list names no file");
            }
        }
        Ok(files)
    }

    /// Reads several files in parallel. The ones that can't be read are named, and with `--strict` or when none is left
    /// an error.
    fn load_list(&self, files: &[String]) -> Result<Loaded> {
        let bar = progress_bar("reading");
        bar.set_length(files.len() as u64);
        let read = |file: &String| {
            let model = load_model(file).map(|model| with_origin(model, file));
            bar.inc(1);
            model
        };
        // One file a task: their sizes differ by thousands.
        let read: Vec<Result<Model>> = files.par_iter().with_max_len(1).map(read).collect();
        bar.finish_and_clear();
        let mut models = Vec::with_capacity(read.len());
        let mut unread_files = Vec::new();
        for model in read {
            match model {
                Ok(model) => models.push(model),
                // A name that no model has is wrong usage in a list too.
                Err(error) if error.is::<UsageError>() => return Err(error),
                Err(error) => unread_files.push(format!("{error:#}")),
            }
        }
        let name = self.label();
        if let Some(first) = unread_files.first() {
            let line = format!("{} of {} files can't be read, the first: {first}", unread_files.len(), files.len());
            if self.strict || models.is_empty() {
                return Err(anyhow!(line));
            }
            output::warning_line(&line);
        }
        Ok(Loaded { name, files: files.len(), unread_files, model: Model::join(models, self.layout) })
    }
}

/// What is said of a file among others names it, and so do its instances.
fn with_origin(mut model: Model, file: &str) -> Model {
    let short = Path::new(file).file_name().map_or(file.into(), |name| name.to_string_lossy());
    for Instance { name, .. } in &mut model.instances {
        *name = if name.is_empty() { short.clone().into_owned() } else { format!("{short}/{name}") };
    }
    for Warning { message, .. } in model.warnings.iter_mut().chain(&mut model.lost) {
        *message = format!("{file}: {message}");
    }
    model
}

/// Reads a model from a file or by the name of a built-in one.
pub fn load_model(source: &str) -> Result<Model> {
    import::load(source).map_err(|error| match error {
        ImportError::Builtin(unknown) => UsageError(unknown.to_string()).into(),
        error => error.into(),
    })
}

/// Prepares a model; on a terminal, standard error shows how far it is.
pub fn prepare_model(model: &Model) -> Result<Scene> {
    let bar = progress_bar("preparing");
    let scene = prepare(model, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    Ok(scene?)
}

/// A progress bar on a terminal's standard error, nothing in a pipe.
pub fn progress_bar(what: &'static str) -> ProgressBar {
    // indicatif hides the bar by itself where standard error is not a terminal.
    let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

/// How many faces a model lost and how many warnings it has, and the first of them.
fn loss_line(model: &Model) -> Option<String> {
    let line = |kind: &str, all: &[Warning]| {
        let first = all.first()?;
        // Most messages name their entity themselves.
        let entity = first.entity.filter(|id| !first.message.contains(&id.to_string()));
        let first = entity.map_or(first.message.clone(), |id| format!("#{id}: {}", first.message));
        Some(match all.len() {
            1 => format!("1 {kind}: {first}"),
            count => format!("{count} {kind}s, the first: {first}"),
        })
    };
    let lines = [line("lost face", &model.lost), line("warning", &model.warnings)];
    let text = lines.into_iter().flatten().collect::<Vec<_>>().join("; ");
    (!text.is_empty()).then_some(text)
}
