//! STEP: ISO 10303-21 files with the geometry of AP203, AP214 and AP242.
//!
//! ```text
//! text --scan--> records --file--> entities --assembly, items--> parts and their faces, placed
//!                                  entities --curve, surface, face--> FaceSource --brep--> Face, in parallel
//! ```
//! Lengths come out in millimetres, angles in radians, whatever the file's units.

mod args;
mod assembly;
mod curve;
mod error;
mod face;
mod file;
mod flatten;
mod invert;
mod items;
mod join;
mod kinds;
mod pcurve;
mod place;
mod products;
mod scan;
mod spline;
mod styles;
mod surface;
mod text;
mod units;

use super::ParseError;
use super::brep::build_face;
use crate::model::{Face, Model, Part, Solidity, Warning};
use assembly::Assembly;
use file::File;
use items::FaceUse;
use place::{Log, Shapes};
use rayon::prelude::*;
use scan::{Scanned, SyntaxError};
use units::Units;

/// Entity numbers that a message lists.
const LISTED: usize = 5;

/// True for files that open like this format; white space and comments may come before.
pub(super) fn matches(bytes: &[u8]) -> bool {
    let text = without_mark(bytes);
    let mut cursor = scan::Cursor { text, at: 0 };
    cursor.blank().is_ok() && text[cursor.at..].starts_with(b"ISO-10303-21")
}

/// Reads a whole file. What can't be read is left out by name, as long as a face is left.
pub(super) fn parse(bytes: &[u8], name: &str) -> Result<Model, ParseError> {
    let text = without_mark(bytes);
    let scanned = scan::scan(text);
    let mut warnings = syntax_warnings(text, &scanned);
    let (file, twice) = File::new(text, scanned.records);
    if !twice.is_empty() {
        let listed: Vec<String> = twice.iter().take(LISTED).map(|id| format!("#{id}")).collect();
        let (count, listed) = (twice.len(), listed.join(", "));
        let message = format!("{count} entities have the number of an earlier one and are left out: {listed}");
        warnings.push(Warning { entity: twice.first().copied(), message });
    }
    let styles = styles::Styles::new(&file);
    let mut assembly = assembly::assemble(&file, &styles);
    let mut model = Model { name: name.to_owned(), unit: Some("mm".into()), warnings, ..Model::default() };
    model.warnings.append(&mut assembly.warnings);
    model.lost.append(&mut assembly.lost);
    let parts = build_parts(&file, &mut assembly, &mut model);
    let (instances, notes) = flatten::flatten(&assembly, &parts);
    model.instances = instances;
    model.warnings.extend(notes);
    if model.instances.iter().all(|i| model.parts[i.part].faces.is_empty()) {
        return Err(nothing(text, &model));
    }
    Ok(model)
}

/// Reads the text alone: how many entities it holds.
pub(super) fn count_entities(bytes: &[u8]) -> u64 {
    let text = without_mark(bytes);
    let (file, _) = File::new(text, scan::scan(text).records);
    file.len() as u64
}

/// The text without a byte order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Syntax errors with line and column, and that the file is cut.
fn syntax_warnings(text: &[u8], scanned: &Scanned) -> Vec<Warning> {
    let warning = |error: &SyntaxError| {
        let (line, column) = place_of(text, error.at);
        let message = format!("line {line}, column {column}: {}; what stands there is left out", error.what);
        Warning { entity: None, message }
    };
    let mut warnings: Vec<Warning> = scanned.errors.iter().map(warning).collect();
    let more = scanned.error_count - scanned.errors.len();
    if more > 0 {
        warnings.push(Warning { entity: None, message: format!("{more} more errors like these") });
    }
    if !scanned.ended {
        let (line, column) = place_of(text, text.len());
        let message = format!("line {line}, column {column}: the file ends before END-ISO-10303-21: it may be cut");
        warnings.push(Warning { entity: None, message });
    }
    warnings
}

/// Line and column of an offset, from 1; lines end with LF, CR LF or CR.
fn place_of(text: &[u8], at: usize) -> (usize, usize) {
    let before = &text[..at.min(text.len())];
    let ends = |k: usize| before[k] == b'\n' || (before[k] == b'\r' && text.get(k + 1) != Some(&b'\n'));
    let line = 1 + (0..before.len()).filter(|&k| ends(k)).count();
    let start = (0..before.len()).rev().find(|&k| ends(k)).map_or(0, |k| k + 1);
    (line, 1 + before.len() - start)
}

/// Why a file gives no model: the first thing that went wrong.
fn nothing(text: &[u8], model: &Model) -> ParseError {
    let why = model.lost.first().or(model.warnings.first()).map_or(String::new(), |w| format!(" ({})", w.message));
    let why: String = why.chars().take(300).collect();
    ParseError { line: place_of(text, text.len()).0, what: format!("no face could be read{why}") }
}

/// A face to be built for a part.
struct Job<'j> {
    part: usize,
    units: Units,
    face: &'j FaceUse,
}

/// Faces of all nodes as parts, solids apart from open ones; the parts of each node.
fn build_parts(file: &File, assembly: &mut Assembly, model: &mut Model) -> Vec<Vec<usize>> {
    let mut parts = vec![Vec::new(); assembly.nodes.len()];
    let mut jobs = Vec::new();
    for (node, own) in assembly.nodes.iter().zip(&mut parts) {
        for solidity in [Solidity::Solid, Solidity::Open] {
            let part = model.parts.len();
            let before = jobs.len();
            for (units, contents) in &node.groups {
                let faces = if solidity == Solidity::Solid { &contents.solid } else { &contents.open };
                jobs.extend(faces.iter().map(|face| Job { part, units: *units, face }));
            }
            if jobs.len() > before {
                model.parts.push(Part { id: node.id, name: node.name.clone(), faces: Vec::new(), solidity });
                own.push(part);
            }
        }
    }
    let built: Vec<_> = jobs.par_iter().map(|job| build(file, job)).collect();
    for (job, (face, log)) in jobs.iter().zip(built) {
        model.warnings.extend(log.notes.into_inner());
        if log.doubtful.get() {
            // Its walls may show their backs.
            model.parts[job.part].solidity = Solidity::Open;
        }
        match face {
            Ok(face) => model.parts[job.part].faces.push(face),
            Err(message) => model.lost.push(Warning { entity: Some(job.face.id), message }),
        }
    }
    parts
}

/// One face, or why it is lost, and what was mended.
fn build(file: &File, job: &Job) -> (Result<Face, String>, Log) {
    let log = Log::default();
    let shapes = Shapes { file, units: job.units, log: &log };
    let id = job.face.id;
    let built = shapes.face(job.face).map_err(|e| e.to_string()).and_then(|source| {
        let built = build_face(&source).map_err(|e| e.to_string())?;
        for warning in built.warnings {
            shapes.note(id, warning);
        }
        Ok(built.face)
    });
    let built = built.map_err(|why| format!("face #{id} is lost: {why}"));
    (built, log)
}
