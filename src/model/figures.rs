//! A model in figures: how many faces and patches, of what degree, how large (ETER's table 2, and what else is asked).

use super::{Instance, Model, SurfacePatch};
use crate::geometry::{Estimate, patch_area, rough_patch_area};
use glam::DMat3;
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// The area settles to this fraction of the whole, spread over the patches.
const AREA_TOLERANCE: f64 = 1e-7;

/// What `info` says of a model; the names are those of its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Faces that are drawn: every instance counts.
    pub faces: usize,
    /// Faces that are stored.
    pub unique_faces: usize,
    /// Surfaces that are stored.
    pub surfaces: usize,
    /// Rational Bézier patches that are stored.
    pub bezier_patches: usize,
    /// Patches of each degree; in JSON by "UxV".
    #[serde(serialize_with = "by_name")]
    pub degrees: BTreeMap<[usize; 2], usize>,
    /// Patches whose weights differ.
    pub rational: usize,
    /// Trim loops.
    pub trims: usize,
    /// Of all faces that are drawn, in squared units.
    pub area: f64,
    /// What the area may still be off by, as a fraction of it; an estimate.
    pub area_relative_error: f64,
    /// Box of all control points in the world: lowest and highest corner.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// The file's unit of length, where it names one.
    pub unit: Option<String>,
    pub instances: usize,
    /// What could not be taken over, one line each.
    pub warnings: Vec<String>,
}

fn by_name<S: Serializer>(degrees: &BTreeMap<[usize; 2], usize>, to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(degrees.iter().map(|([u, v], count)| (format!("{u}x{v}"), count)))
}

impl Model {
    /// Counts and measures; `progress` is told how many patches are measured, from any thread.
    pub fn figures(&self, progress: &(dyn Fn(usize, usize) + Sync)) -> Figures {
        let faces = || self.parts.iter().flat_map(|p| &p.faces);
        let patches = || faces().flat_map(|f| &f.surface.patches);
        let mut degrees = BTreeMap::new();
        for patch in patches() {
            let [u, v] = patch.patch.degree();
            *degrees.entry([u, v]).or_insert(0) += 1;
        }
        let area = self.area(progress);
        Figures {
            faces: self.instances.iter().map(|i| self.parts[i.part].faces.len()).sum(),
            unique_faces: faces().count(),
            surfaces: faces().count(),
            bezier_patches: patches().count(),
            degrees,
            rational: patches().filter(|p| p.patch.net().is_rational()).count(),
            trims: 0,
            area: area.value,
            area_relative_error: if area.value == 0.0 { 0.0 } else { area.error / area.value },
            bounds: self.bounds().map(|b| b.map(Into::into)),
            unit: self.unit.clone(),
            instances: self.instances.len(),
            warnings: self.warnings.iter().map(|w| w.message.clone()).collect(),
        }
    }

    /// Area of all faces that are drawn.
    fn area(&self, progress: &(dyn Fn(usize, usize) + Sync)) -> Estimate {
        // Turned and uniformly scaled copies need no quadrature of their own.
        let mut shapes: Vec<Shape> = Vec::new();
        for instance in &self.instances {
            let (map, factor) = shape_and_factor(instance);
            match shapes.iter_mut().find(|s| s.part == instance.part && s.map == map) {
                Some(shape) => shape.factor += factor,
                None => shapes.push(Shape { part: instance.part, map, factor }),
            }
        }
        let jobs: Vec<_> = shapes.iter().flat_map(|s| self.patches_of(s.part).map(move |p| (s, p))).collect();
        let rough: Vec<f64> = jobs.par_iter().map(|(s, p)| s.factor * rough_patch_area(p.patch.net(), s.map)).collect();
        let tolerance = AREA_TOLERANCE * rough.iter().sum::<f64>() / jobs.len().max(1) as f64;
        let done = std::sync::atomic::AtomicUsize::new(0);
        let measure = |(shape, patch): &(&Shape, &SurfacePatch)| {
            let area = patch_area(patch.patch.net(), shape.map, tolerance / shape.factor);
            let count = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if count.is_multiple_of(256) {
                progress(count, jobs.len());
            }
            Estimate { value: shape.factor * area.value, error: shape.factor * area.error }
        };
        // Collected first: the sum does not depend on the threads.
        let areas: Vec<Estimate> = jobs.par_iter().map(measure).collect();
        areas.iter().fold(Estimate::default(), |a, b| Estimate { value: a.value + b.value, error: a.error + b.error })
    }

    fn patches_of(&self, part: usize) -> impl Iterator<Item = &SurfacePatch> {
        self.parts[part].faces.iter().flat_map(|f| &f.surface.patches)
    }
}

/// A part under a linear map, with how often its area counts.
struct Shape {
    part: usize,
    map: DMat3,
    factor: f64,
}

/// The linear map to integrate under and the factor on the area: for a similarity the identity and its scale squared.
fn shape_and_factor(instance: &Instance) -> (DMat3, f64) {
    let map: DMat3 = instance.transform.matrix3;
    let gram = map.transpose() * map;
    let scale = gram.x_axis.x;
    if scale > 0.0 && gram.abs_diff_eq(DMat3::from_diagonal(glam::DVec3::splat(scale)), 1e-12 * scale) {
        (DMat3::IDENTITY, scale)
    } else {
        (map, 1.0)
    }
}
