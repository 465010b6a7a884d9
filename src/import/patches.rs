//! What readers of bare patches share: collecting faces, and saying what was left out.

use super::ParseError;
use super::scan::Stop;
use crate::geometry::BezierPatch;
use crate::model::{Face, Model, Part, Surface, Warning};
use glam::DVec4;

/// The patches of one file, in its order.
#[derive(Default)]
pub(super) struct Patches {
    faces: Vec<Face>,
    warnings: Vec<Warning>,
    /// Patches met so far, taken over or not; the next one's number.
    met: u32,
}

impl Patches {
    /// Patches met so far, taken over or not.
    pub fn met(&self) -> u32 {
        self.met
    }

    /// Takes a patch over, or warns why it can't be.
    pub fn add(&mut self, line: usize, degree: [usize; 2], points: Vec<DVec4>, name: &str, color: Option<[f32; 3]>) {
        let id = self.met;
        self.met += 1;
        match BezierPatch::new("", degree, points) {
            Ok(patch) => self.faces.push(Face { color, ..Face::new(id, name, Surface::single(patch)) }),
            Err(error) => self.warn(line, format!("patch {id} is left out{error}")),
        }
    }

    /// Notes what was left out or mended.
    pub fn warn(&mut self, line: usize, message: String) {
        self.warnings.push(Warning { entity: u32::try_from(line).ok(), message: format!("line {line}: {message}") });
    }

    /// Notes where a file that ends early was cut; anything else that stopped the reader is an error.
    pub fn stopped(&mut self, stop: Stop) -> Result<(), ParseError> {
        match stop {
            Stop::Bad { line, what } => Err(ParseError { line, what }),
            Stop::End { line } => {
                let met = self.met;
                self.warn(line, format!("the file ends inside patch {met}; {met} complete ones before it were read"));
                Ok(())
            }
        }
    }

    /// The model, if anything was taken over; `line` is the file's last.
    pub fn into_model(mut self, name: &str, line: usize) -> Result<Model, ParseError> {
        if self.faces.is_empty() {
            let why = self.warnings.first().map_or(String::new(), |w| format!(" ({})", w.message));
            return Err(ParseError { line, what: format!("no patch could be read{why}") });
        }
        let part = Part { name: name.to_owned(), faces: self.faces, ..Part::default() };
        let mut model = Model::from_part(name, part);
        model.warnings.append(&mut self.warnings);
        Ok(model)
    }
}
