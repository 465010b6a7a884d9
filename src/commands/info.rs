//! `halfpixel info`: a model in figures, as a table or as JSON.

use super::args::{ModelArgs, prepare_model, progress_bar};
use super::output;
use crate::model::{Figures, Model};
use crate::scene::Scene;
use anyhow::Result;
use serde::Serialize;
use std::{fmt::Write, process::ExitCode};

/// Describe a model in figures: faces, patches, degrees, area, memory
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub model: ModelArgs,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// The JSON object.
#[derive(Serialize)]
struct Info<'a> {
    model: &'a str,
    #[serde(flatten)]
    figures: Figures,
    /// What the prepared model takes at run time; null where it can't be prepared (a warning says why).
    bytes: Option<usize>,
    bytes_geometry: Option<usize>,
    bytes_trims: Option<usize>,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let info = args.model.install(|| {
        let model = args.model.load_silently()?;
        Ok(describe(&args.model.model, &model))
    })?;
    if args.json {
        output::print_json(&info)?;
    } else {
        output::print(table(&info).trim_end())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn describe<'a>(name: &'a str, model: &Model) -> Info<'a> {
    let bar = progress_bar("measuring");
    let mut figures = model.figures(&|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    let bytes = match prepare_model(model) {
        Ok(scene) => Some([geometry_bytes(&scene), scene.trim_bytes()]),
        Err(error) => {
            figures.warnings.push(format!("the model can't be prepared for drawing: {error:#}"));
            None
        }
    };
    let [geometry, trims] = [0, 1].map(|k| bytes.map(|b| b[k]));
    Info { model: name, figures, bytes: bytes.map(|b| b[0] + b[1]), bytes_geometry: geometry, bytes_trims: trims }
}

/// What a prepared scene takes in memory, without the allocator's own share.
fn geometry_bytes(scene: &Scene) -> usize {
    let names: usize = scene.faces.iter().map(|f| f.name.len()).sum();
    size_of_val(&scene.points[..])
        + size_of_val(&scene.patches[..])
        + size_of_val(&scene.faces[..])
        + size_of_val(&scene.instances[..])
        + names
}

fn table(info: &Info) -> String {
    let f = &info.figures;
    let unit = f.unit.as_deref().unwrap_or("units");
    let degrees: Vec<String> = f.degrees.iter().map(|([u, v], n)| format!("{u}x{v} ({n})")).collect();
    let bytes = |b: Option<usize>| b.map_or("-".to_owned(), |b| format!("{:.2} MB", b as f64 / 1e6));
    let corner = |c: [f64; 3]| c.map(|x| format!("{x}")).join(", ");
    let bounds = f.bounds.map_or("-".to_owned(), |[low, high]| format!("{} to {} {unit}", corner(low), corner(high)));
    let rows = [
        ("model", info.model.to_owned()),
        ("faces", format!("{} ({} stored, {} instances)", f.faces, f.unique_faces, f.instances)),
        ("surfaces", f.surfaces.to_string()),
        ("Bézier patches", f.bezier_patches.to_string()),
        ("degrees", degrees.join(", ")),
        ("rational", f.rational.to_string()),
        ("trim loops", f.trims.to_string()),
        ("area", format!("{} {unit}² (relative error {:.1e})", significant(f.area), f.area_relative_error)),
        ("bounds", bounds),
        ("memory", format!("{} + {} trims", bytes(info.bytes_geometry), bytes(info.bytes_trims))),
        ("warnings", f.warnings.len().to_string()),
    ];
    let mut text = String::new();
    for (name, value) in rows {
        let _ = writeln!(text, "{name:<15}{value}");
    }
    for warning in &f.warnings {
        let _ = writeln!(text, "  {warning}");
    }
    text
}

/// Ten significant digits, without a long tail of zeros.
fn significant(x: f64) -> String {
    let rounded: f64 = format!("{x:.9e}").parse().unwrap_or(x);
    rounded.to_string()
}
