//! STEP: ISO 10303-21 files with the geometry of AP203, AP214 and AP242.
//!
//! ```text
//! text --scan--> records --file--> entities --assembly, items--> parts and their faces, placed
//!                                  entities --curve, surface, face--> FaceSource --brep--> Face, in parallel
//! ```
//! Lengths come out in millimetres, angles in radians, whatever the file's units.

mod args;
mod assembly;
mod cursor;
mod curve;
mod error;
mod external;
mod face;
mod file;
mod flatten;
mod invert;
mod items;
mod join;
mod kinds;
mod number;
mod pcurve;
mod place;
mod products;
mod recolor;
mod replica;
mod scan;
mod spline;
mod styles;
mod surface;
mod text;
mod units;

use super::brep::build_face;
use super::{Origin, ParseError};
use crate::model::{Face, Group, Model, Part, Solidity, Warning};
use assembly::{Assembly, NodePart};
use file::File;
use items::FaceUse;
use place::{Log, Shapes};
use rayon::prelude::*;
use scan::{Scanned, SyntaxError};
use std::ops::Range;
use units::Units;

/// Entity numbers that a message lists.
const LISTED: usize = 5;

/// True for files that open like this format; white space and comments may come before.
pub(super) fn matches(bytes: &[u8]) -> bool {
    let text = without_mark(bytes);
    let mut cursor = cursor::Cursor { text, at: 0 };
    cursor.blank().is_ok() && text[cursor.at..].starts_with(b"ISO-10303-21")
}

/// Reads a whole file. What can't be read is left out by name, as long as a face is left.
pub(super) fn parse(bytes: &[u8], origin: &Origin) -> Result<Model, ParseError> {
    let text = without_mark(bytes);
    let scanned = scan::scan(text);
    let mut warnings = syntax_warnings(text, &scanned);
    let (file, twice) = File::new(text, scanned);
    if !twice.is_empty() {
        let listed: Vec<String> = twice.iter().take(LISTED).map(|id| format!("#{id}")).collect();
        let (count, listed) = (twice.len(), listed.join(", "));
        let message = format!("{count} entities have the number of an earlier one and are left out: {listed}");
        warnings.push(Warning { entity: twice.first().copied(), message });
    }
    let styles = styles::Styles::new(&file);
    let mut assembly = assembly::assemble(&file, &styles);
    let mut model = Model { name: origin.name.clone(), unit: Some("mm".into()), warnings, ..Model::default() };
    model.warnings.append(&mut assembly.warnings);
    model.lost.append(&mut assembly.lost);
    model.aliases = std::mem::take(&mut assembly.aliases);
    let mut parts = build_parts(&file, &assembly, &mut model);
    external::attach(&mut assembly, &mut parts, &mut model, origin);
    let recolor = recolor::Recolor::new(&styles.overrides, &assembly, &model.parts);
    let flat = flatten::flatten(&assembly, &parts, &model.parts, &recolor);
    model.instances = flat.instances;
    model.warnings.extend(flat.warnings);
    model.unshown.hidden_faces += flat.hidden.iter().map(|&part| model.parts[part].faces.len()).sum::<usize>();
    if model.instances.iter().all(|i| model.parts[i.part].faces.is_empty()) {
        return Err(nothing(text, &model));
    }
    Ok(model)
}

/// Reads the text alone: how many entities it holds.
pub(super) fn count_entities(bytes: &[u8]) -> u64 {
    let text = without_mark(bytes);
    let (file, _) = File::new(text, scan::scan(text));
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
    if scanned.elsewhere > 0 {
        let message = format!("{} entities stand in other files and are not read (REFERENCE)", scanned.elsewhere);
        warnings.push(Warning { entity: None, message });
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
    let first = model.lost.first().or(model.warnings.first()).map(|w| w.message.clone());
    let hidden = model.unshown.hidden_faces;
    let first = first.or_else(|| (hidden > 0).then(|| format!("the file hides all of its {hidden} faces")));
    let why = first.map_or(String::new(), |why| format!(" ({why})"));
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
fn build_parts(file: &File, assembly: &Assembly, model: &mut Model) -> Vec<Vec<usize>> {
    let mut parts = vec![Vec::new(); assembly.nodes.len()];
    for contents in assembly.nodes.iter().flat_map(|node| &node.groups).map(|part| &part.contents) {
        model.unshown.hidden_faces += contents.unshown.hidden_faces;
        model.unshown.lone_curves += contents.unshown.lone_curves;
    }
    let mut jobs = Vec::new();
    for (node, own) in assembly.nodes.iter().zip(&mut parts) {
        for solidity in [Solidity::Solid, Solidity::Open] {
            let part = model.parts.len();
            let before = jobs.len();
            let mut groups = Vec::new();
            for NodePart { id, units, contents } in &node.groups {
                let is_solid = solidity == Solidity::Solid;
                let faces = if is_solid { &contents.solid } else { &contents.open };
                let first = jobs.len() - before;
                jobs.extend(faces.iter().map(|face| Job { part, units: *units, face }));
                let own = |group: &items::Group| {
                    let Range { start, end } = if is_solid { group.solid.clone() } else { group.open.clone() };
                    let (id, name) = (group.id, group.name.clone());
                    Group { id, name, is_solid: is_solid && group.is_solid, faces: first + start..first + end }
                };
                groups.push(Group { id: *id, faces: first..first + faces.len(), is_solid, ..Group::default() });
                groups.extend(contents.groups.iter().map(own));
            }
            groups.retain(|group| !group.faces.is_empty() && group.id != 0);
            if jobs.len() > before {
                let (id, name) = (node.id, node.name.clone());
                model.parts.push(Part { id, name, solidity, groups, ..Part::default() });
                own.push(part);
            }
        }
    }
    let built: Vec<_> = jobs.par_iter().map(|job| build(file, job)).collect();
    // Where each job's face is in its part, or would be.
    let mut places = Vec::with_capacity(jobs.len());
    for (job, (face, log)) in jobs.iter().zip(built) {
        model.warnings.extend(log.notes.into_inner());
        let part = &mut model.parts[job.part];
        if log.doubtful.get() {
            // Its walls may show their backs.
            part.solidity = Solidity::Open;
        }
        let faces = &mut part.faces;
        places.push(faces.len());
        match face {
            Ok(face) => faces.push(face),
            Err(message) => model.lost.push(Warning { entity: Some(job.face.id), message }),
        }
    }
    // Groups follow their faces past those that are lost.
    let mut first = 0;
    for part in &mut model.parts {
        let count = jobs[first..].partition_point(|job| job.part == jobs[first].part);
        let place = |k: usize| if k < count { places[first + k] } else { part.faces.len() };
        part.groups.iter_mut().for_each(|group| group.faces = place(group.faces.start)..place(group.faces.end));
        part.groups.retain(|group| !group.faces.is_empty());
        first += count;
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
