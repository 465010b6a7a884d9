//! Several models as one.

use super::{Instance, Model, Warning};
use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;

/// Where the models of several files stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Layout {
    /// Each in its own place.
    #[default]
    Overlay,
    /// Side by side, by their boxes, in rows of about the same width.
    Grid,
}

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
            let Model { name, parts, instances, unit, warnings, lost, unshown, aliases } = model;
            let first = all.parts.len();
            all.parts.extend(parts);
            all.instances.extend(instances.into_iter().map(|mut instance| {
                instance.part += first;
                instance.transform = DAffine3::from_translation(place) * instance.transform;
                instance
            }));
            all.warnings.extend(warnings);
            all.lost.extend(lost);
            all.unshown.hidden_faces += unshown.hidden_faces;
            all.unshown.lone_curves += unshown.lone_curves;
            all.aliases.extend(aliases);
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
}

/// So many copies of a model side by side, in a square of rows from left to right; they share its parts.
pub fn repeated(instances: &[Instance], [low, high]: [DVec3; 2], copies: usize) -> Vec<Instance> {
    let side = (copies as f64).sqrt().ceil().max(1.0) as usize;
    let cell = (high - low) + SPACING * (high - low).max_element();
    let place = |copy: usize| DVec3::new((copy % side) as f64 * cell.x, -((copy / side) as f64) * cell.y, 0.0);
    let moved = |copy: usize| {
        let place = DAffine3::from_translation(place(copy));
        instances.iter().map(move |instance| Instance { transform: place * instance.transform, ..instance.clone() })
    };
    (0..copies).flat_map(moved).collect()
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
