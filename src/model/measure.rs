//! Surface area: quadrature on the exact surfaces, inside their trims.

use super::{Face, Instance, Model};
use crate::geometry::{Estimate, Outline, Tile, patch_area, rough_patch_area, trimmed_area};
use glam::DMat3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A face's area settles to this fraction of it.
const AREA_TOLERANCE: f64 = 1e-8;

/// Areas of a model's faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Areas {
    /// Of every stored face in its part's own units, in the order of the parts.
    pub faces: Vec<Estimate>,
    /// Of all faces that are drawn, in the world.
    pub total: Estimate,
}

/// A part under a linear map, with how often its area counts.
struct Shape {
    part: usize,
    /// `None`: as it is.
    map: Option<DMat3>,
    factor: f64,
}

impl Model {
    /// Measures every face; `progress` is told how many are done, from any thread.
    pub fn measure(&self, progress: &(dyn Fn(usize, usize) + Sync)) -> Areas {
        let shapes = self.shapes();
        let jobs: Vec<(&Shape, &Face)> =
            shapes.iter().flat_map(|s| self.parts[s.part].faces.iter().map(move |f| (s, f))).collect();
        let done = AtomicUsize::new(0);
        // Collected first: the sum does not depend on the threads.
        let measured: Vec<Estimate> = (jobs.par_iter())
            .map(|(shape, face)| {
                let count = 1 + done.fetch_add(1, Ordering::Relaxed);
                if count.is_multiple_of(256) {
                    progress(count, jobs.len());
                }
                face_area(face, shape.map.unwrap_or(DMat3::IDENTITY))
            })
            .collect();
        let mut areas = Areas::default();
        for ((shape, _), area) in jobs.into_iter().zip(measured) {
            areas.total.value += shape.factor * area.value;
            areas.total.error += shape.factor * area.error;
            if shape.map.is_none() {
                areas.faces.push(area);
            }
        }
        areas
    }

    /// All parts as they are, in order, and those that instances distort. Turned and uniformly scaled copies need no
    /// quadrature of their own.
    fn shapes(&self) -> Vec<Shape> {
        let mut shapes: Vec<Shape> = (0..self.parts.len()).map(|part| Shape { part, map: None, factor: 0.0 }).collect();
        let mut distorted = HashMap::new();
        for instance in &self.instances {
            match similarity(instance) {
                Some(factor) => shapes[instance.part].factor += factor,
                None => {
                    let map: DMat3 = instance.transform.matrix3;
                    let key = (instance.part, map.to_cols_array().map(f64::to_bits));
                    let at = *distorted.entry(key).or_insert_with(|| {
                        shapes.push(Shape { part: instance.part, map: Some(map), factor: 0.0 });
                        shapes.len() - 1
                    });
                    shapes[at].factor += 1.0;
                }
            }
        }
        shapes
    }
}

/// The square of an instance's scale; `None` where it distorts.
fn similarity(instance: &Instance) -> Option<f64> {
    let map: DMat3 = instance.transform.matrix3;
    let gram = map.transpose() * map;
    let scale = gram.x_axis.x;
    let similar = gram.abs_diff_eq(DMat3::from_diagonal(glam::DVec3::splat(scale)), 1e-12 * scale);
    (scale > 0.0 && similar).then_some(scale)
}

fn face_area(face: &Face, map: DMat3) -> Estimate {
    let patches = &face.surface.patches;
    if !face.loops.is_empty() {
        let tiles: Vec<Tile> = patches.iter().map(|p| Tile { net: p.patch.net(), domain: p.domain }).collect();
        let outlines: Vec<Outline> = face.loops.iter().map(|l| l.curves.iter().map(|c| &c.curve).collect()).collect();
        return trimmed_area(&tiles, &outlines, map, AREA_TOLERANCE);
    }
    let rough: f64 = patches.iter().map(|p| rough_patch_area(p.patch.net(), map)).sum();
    let tolerance = AREA_TOLERANCE * rough / patches.len() as f64;
    patches.iter().fold(Estimate::default(), |sum, p| {
        // Nothing to settle where there is no area, or none that is a number.
        let area = if tolerance > 0.0 { patch_area(p.patch.net(), map, tolerance) } else { Estimate::default() };
        Estimate { value: sum.value + area.value, error: sum.error + area.error }
    })
}
