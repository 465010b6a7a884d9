//! `halfpixel info`: a model in figures, as a table or as JSON.

use super::output;
use super::source::{Loaded, ModelArgs, prepare_model, progress_bar};
use crate::model::{FaceFigures, Figures};
use crate::scene::Scene;
use anyhow::Result;
use serde::Serialize;
use std::{fmt::Write, process::ExitCode};

/// Describe a model in figures: faces, patches, degrees, trims, area, memory
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub model: ModelArgs,
    /// List every stored face: entity, surface, patches, loops, area, warnings
    #[arg(long)]
    pub faces: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// The JSON object.
#[derive(Serialize)]
struct Info {
    #[serde(flatten)]
    source: Loaded,
    #[serde(flatten)]
    figures: Figures,
    /// What the prepared model takes at run time; null where it can't be prepared (a warning says why).
    bytes: Option<usize>,
    bytes_geometry: Option<usize>,
    /// Trim loops, as the oracle reads them.
    bytes_loops: Option<usize>,
    /// Trim trees, as the frame does.
    bytes_trims: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    face_list: Option<Vec<FaceFigures>>,
}

/// What a prepared scene takes in memory, without the allocator's own share.
#[derive(Clone, Copy)]
struct Bytes {
    geometry: usize,
    loops: usize,
    trims: usize,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let info = args.model.install(|| Ok(describe(args.model.load_silently()?, args.faces)))?;
    if args.json {
        output::print_json(&info)?;
    } else {
        output::print(table(&info).trim_end())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(source: Loaded, list: bool) -> Info {
    let model = &source.model;
    let bar = progress_bar("measuring");
    let areas = model.measure(&|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    let mut figures = model.figures(&areas);
    let face_list = list.then(|| model.list_faces(&areas));
    let bytes = match prepare_model(model) {
        Ok(scene) => Some(Bytes::of(&scene)),
        Err(error) => {
            figures.warnings.push(format!("the model can't be prepared for drawing: {error:#}"));
            None
        }
    };
    Info {
        source,
        figures,
        bytes: bytes.map(|b| b.geometry + b.loops + b.trims),
        bytes_geometry: bytes.map(|b| b.geometry),
        bytes_loops: bytes.map(|b| b.loops),
        bytes_trims: bytes.map(|b| b.trims),
        face_list,
    }
}

impl Bytes {
    fn of(scene: &Scene) -> Self {
        let names: usize = scene.faces.iter().map(|f| f.name.len()).sum();
        let geometry = size_of_val(&scene.points[..])
            + size_of_val(&scene.patches[..])
            + size_of_val(&scene.faces[..])
            + size_of_val(&scene.instances[..])
            + names;
        let loops = || scene.faces.iter().flat_map(|f| f.loops.iter());
        let curves = loops().flat_map(|l| &l.curves);
        let loops = curves.map(|c| size_of_val(c) + size_of_val(c.curve.points())).sum::<usize>()
            + loops().map(size_of_val).sum::<usize>();
        Self { geometry, loops, trims: scene.trim_bytes() }
    }
}

fn table(info: &Info) -> String {
    let f = &info.figures;
    let unit = f.unit.as_deref().unwrap_or("units");
    let degrees: Vec<String> = f.degrees.iter().map(|([u, v], n)| format!("{u}x{v} ({n})")).collect();
    let types: Vec<String> = f.surface_types.iter().map(|(kind, n)| format!("{kind} ({n})")).collect();
    let bytes = |b: Option<usize>| b.map_or("-".to_owned(), |b| format!("{:.2} MB", b as f64 / 1e6));
    let corner = |c: [f64; 3]| c.map(|x| format!("{x}")).join(", ");
    let bounds = f.bounds.map_or("-".to_owned(), |[low, high]| format!("{} to {} {unit}", corner(low), corner(high)));
    let memory = format!(
        "{} + {} trim loops + {} trim trees",
        bytes(info.bytes_geometry),
        bytes(info.bytes_loops),
        bytes(info.bytes_trims)
    );
    let stored = format!("{} ({} stored in {} parts, {} instances)", f.faces, f.unique_faces, f.parts, f.instances);
    let mut rows = vec![
        ("model", info.source.name.clone()),
        ("faces", stored),
        ("lost faces", f.lost_faces.to_string()),
        ("surfaces", types.join(", ")),
        ("Bézier patches", f.bezier_patches.to_string()),
        ("degrees", degrees.join(", ")),
        ("rational", f.rational.to_string()),
        ("trimmed faces", format!("{} ({} loops of {} curves, {} edges)", f.trims, f.loops, f.trim_curves, f.edges)),
        ("largest gap", format!("{} {unit}", significant(f.largest_gap))),
        ("approximated", approximated(f, unit)),
        ("area", format!("{} {unit}² (relative error {:.1e})", significant(f.area), f.area_relative_error)),
        ("bounds", bounds),
        ("memory", memory),
        ("warnings", f.warnings.len().to_string()),
    ];
    if f.hidden_faces + f.lone_curves > 0 {
        rows.push(("not shown", format!("{} hidden faces, {} curves without a face", f.hidden_faces, f.lone_curves)));
    }
    if info.source.files > 1 {
        let unread = info.source.unread_files.len();
        rows.insert(1, ("files", format!("{} ({unread} can't be read)", info.source.files)));
    }
    let mut text = String::new();
    for (name, value) in rows {
        let _ = writeln!(text, "{name:<15}{value}");
    }
    let lost =
        f.lost.iter().map(|l| format!("lost{}: {}", l.entity.map_or(String::new(), |e| format!(" #{e}")), l.message));
    for line in info.source.unread_files.iter().cloned().chain(lost).chain(f.warnings.iter().cloned()) {
        let _ = writeln!(text, "  {line}");
    }
    for face in info.face_list.iter().flatten() {
        let _ = writeln!(text, "{}", face_line(face, unit));
    }
    text
}

fn face_line(face: &FaceFigures, unit: &str) -> String {
    let FaceFigures { entity, surface, bezier_patches, loops, area, area_relative_error, .. } = face;
    let approximated = match face.approximated_curves {
        0 => String::new(),
        curves => format!(", {curves} trim curves approximated to {:.1e} {unit}", face.approximation),
    };
    let warnings = face.warnings.iter().map(|w| format!("; {w}")).collect::<String>();
    format!(
        "#{entity} {surface}, {bezier_patches} patches, {loops} loops, {} {unit}² ({area_relative_error:.0e}){approximated}{warnings}",
        significant(*area)
    )
}

/// Trim curves that are not the images of their edges; on which faces, `--faces` says.
fn approximated(f: &Figures, unit: &str) -> String {
    match f.approximated_curves {
        0 => "no trim curve".to_owned(),
        curves => {
            format!("{curves} trim curves of {} faces, to {:.1e} {unit}", f.approximated_faces, f.largest_approximation)
        }
    }
}

/// Ten significant digits, without a long tail of zeros.
fn significant(x: f64) -> String {
    let rounded: f64 = format!("{x:.9e}").parse().unwrap_or(x);
    rounded.to_string()
}
