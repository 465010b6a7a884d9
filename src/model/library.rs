//! Several models as one, and one part of a model.

use super::{Face, Model, Part, Warning};
use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use thiserror::Error;

/// Where the models of several files stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Layout {
    /// Each in its own place.
    #[default]
    Overlay,
    /// Side by side, by their boxes, in rows of about the same width.
    Grid,
}

/// Why a part could not be selected.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PartError {
    #[error("there is no part, solid or face #{id}")]
    NoEntity { id: String },
    #[error("there is no part named {name:?}; there are: {known}")]
    NoName { name: String, known: String },
}

/// Names that an error lists.
const LISTED: usize = 12;

/// Space about each model of a grid, as a fraction of its larger side.
const SPACING: f64 = 0.1;

impl Model {
    /// All models as one, in their order; nothing is copied. Files in different units are put together by their numbers,
    /// with a warning.
    pub fn join(models: Vec<Model>, layout: Layout) -> Model {
        let places = match layout {
            Layout::Overlay => vec![DVec3::ZERO; models.len()],
            Layout::Grid => grid(&models),
        };
        let mut all = Model::default();
        let mut units: Vec<Option<String>> = Vec::new();
        for (model, place) in models.into_iter().zip(places) {
            let Model { name, parts, instances, unit, warnings, lost } = model;
            let first = all.parts.len();
            all.parts.extend(parts);
            all.instances.extend(instances.into_iter().map(|mut instance| {
                instance.part += first;
                instance.transform = DAffine3::from_translation(place) * instance.transform;
                instance
            }));
            all.warnings.extend(warnings);
            all.lost.extend(lost);
            if !units.contains(&unit) {
                units.push(unit);
            }
            if all.name.is_empty() {
                all.name = name;
            }
        }
        let [unit] = &mut units[..] else {
            if units.len() > 1 {
                let named: Vec<&str> = units.iter().map(|u| u.as_deref().unwrap_or("none")).collect();
                let message = format!("the files have different units ({}): sizes can't be compared", named.join(", "));
                all.warnings.push(Warning { entity: None, message });
            }
            return all;
        };
        all.unit = unit.take();
        all
    }

    /// Keeps one part: `#ID` is the file's number of a part or of a single face; anything else the name of a part or of an
    /// instance, whole or between slashes, if need be without regard to case.
    pub fn select(self, part: &str) -> Result<Model, PartError> {
        let Some(id) = part.strip_prefix('#') else { return self.select_named(part) };
        let missing = || PartError::NoEntity { id: id.to_owned() };
        let number: u32 = id.parse().map_err(|_| missing())?;
        if number != 0 && self.parts.iter().any(|p| p.id == number) {
            return Ok(self.keep(|part, _| part.id == number));
        }
        let is_it = |face: &Face| face.id == number;
        let mut model = self.keep(|part, _| part.faces.iter().any(is_it));
        model.parts.iter_mut().for_each(|part| part.faces.retain(is_it));
        // A single face bounds no solid.
        model.parts.iter_mut().for_each(|part| part.solidity = super::Solidity::Open);
        if model.parts.is_empty() { Err(missing()) } else { Ok(model) }
    }

    fn select_named(self, name: &str) -> Result<Model, PartError> {
        let exact = |other: &str| other == name;
        let lower = name.to_lowercase();
        let any_case = |other: &str| other.to_lowercase() == lower;
        for same in [&exact as &dyn Fn(&str) -> bool, &any_case] {
            let is_it =
                |part: &Part, instance: &str| same(&part.name) || same(instance) || instance.split('/').any(same);
            if self.instances.iter().any(|i| is_it(&self.parts[i.part], &i.name)) {
                return Ok(self.keep(is_it));
            }
        }
        Err(PartError::NoName { name: name.to_owned(), known: self.known_names() })
    }

    /// Drops the other instances, and the parts that none is left of.
    fn keep(mut self, wanted: impl Fn(&Part, &str) -> bool) -> Model {
        let parts = &self.parts;
        self.instances.retain(|i| wanted(&parts[i.part], &i.name));
        let mut numbers = vec![None; self.parts.len()];
        self.instances.iter().for_each(|i| numbers[i.part] = Some(0));
        for (next, number) in numbers.iter_mut().flatten().enumerate() {
            *number = next;
        }
        self.instances.iter_mut().for_each(|i| i.part = numbers[i.part].unwrap_or_default());
        let mut kept = numbers.iter();
        self.parts.retain(|_| kept.next().is_some_and(Option::is_some));
        self
    }

    fn known_names(&self) -> String {
        let mut names: Vec<&str> = self.parts.iter().map(|p| p.name.as_str()).filter(|n| !n.is_empty()).collect();
        names.sort_unstable();
        names.dedup();
        let more = names.len().saturating_sub(LISTED);
        names.truncate(LISTED);
        match (names.is_empty(), more) {
            (true, _) => "none with a name".to_owned(),
            (_, 0) => names.join(", "),
            _ => format!("{} and {more} more", names.join(", ")),
        }
    }
}

/// How far each model moves: rows from left to right, the first at the back, all standing on z = 0. A row is as long as
/// a square of all boxes.
fn grid(models: &[Model]) -> Vec<DVec3> {
    let boxes: Vec<Option<[DVec3; 2]>> = models.par_iter().map(Model::bounds).collect();
    let cell = |[low, high]: [DVec3; 2]| {
        let size = (high - low).truncate();
        size + SPACING * size.max_element()
    };
    let cells: Vec<DVec2> = boxes.iter().map(|b| b.map_or(DVec2::ZERO, cell)).collect();
    let widest = cells.iter().map(|c| c.x).fold(0.0, f64::max);
    let width = cells.iter().map(|c| c.element_product()).sum::<f64>().sqrt().max(widest) * (1.0 + 1e-9);
    let mut places = vec![DVec3::ZERO; models.len()];
    let (mut at, mut back, mut depth) = (0.0, 0.0, 0.0_f64);
    for ((place, bounds), cell) in places.iter_mut().zip(boxes).zip(cells) {
        let Some([low, high]) = bounds else { continue };
        if at > 0.0 && at + cell.x > width {
            (at, back, depth) = (0.0, back - depth, 0.0);
        }
        *place = DVec3::new(at - low.x, back - high.y, -low.z);
        at += cell.x;
        depth = depth.max(cell.y);
    }
    places
}
