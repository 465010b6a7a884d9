//! `Model` to `Scene`: once a model, in parallel, f64.

use super::{
    Bounds, Patch, PatchTrim, Scene, SceneFace, SceneInstance, Sides, enclose, normal_cone, radius,
    trim_faces::trim_faces, visible_sides,
};
use crate::geometry::{BezierPatch, Net};
use crate::model::{Face, Instance, Model, Part, Solidity};
use glam::{DVec3, DVec4};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use thiserror::Error;

/// Linear RGB of faces that have no colour of their own.
const DEFAULT_COLOR: [f32; 3] = [0.55, 0.57, 0.60];
/// Patches between two calls of the progress function.
const PROGRESS_STEP: usize = 1024;

/// Why a model could not be prepared.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PrepareError {
    #[error("the model has no surfaces")]
    Empty,
    #[error("instance {instance} names part {part}, but the model has {parts}")]
    MissingPart { instance: usize, part: usize, parts: usize },
    #[error("the model's coordinates are too large: its box is not finite in f64")]
    Unbounded,
}

/// Prepares a model; `progress(done, all)` is called now and then, from any thread.
pub fn prepare(model: &Model, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Scene, PrepareError> {
    let mut scene = Scene::default();
    let mut sources = Vec::new();
    let faces: Vec<&Face> = model.parts.iter().flat_map(|part| &part.faces).collect();
    if faces.iter().all(|face| face.surface.patches.is_empty()) {
        return Err(PrepareError::Empty);
    }
    let (trims, kept) = trim_faces(&faces);
    scene.trims = trims;
    let mut kept = kept.into_iter();
    let part_patches: Vec<Range<usize>> =
        model.parts.iter().map(|part| collect_part(part, &mut kept, &mut scene.faces, &mut sources)).collect();
    let first_faces: Vec<u32> = (model.parts.iter())
        .scan(0, |next, part| Some(std::mem::replace(next, *next + part.faces.len() as u32)))
        .collect();
    for (k, instance) in model.instances.iter().enumerate() {
        let missing = || PrepareError::MissingPart { instance: k, part: instance.part, parts: model.parts.len() };
        let patches = part_patches.get(instance.part).ok_or_else(missing)?.clone();
        let Instance { name, transform, color, face_colors, .. } = instance.clone();
        let first = first_faces[instance.part];
        let face_colors = face_colors.into_iter().map(|(face, color)| (first + face as u32, color)).collect();
        scene.instances.push(SceneInstance { name, patches, transform, color, face_colors });
    }
    let [low, high] = model.bounds().ok_or(PrepareError::Empty)?;
    scene.bounds = Bounds { low, high };
    if !(scene.bounds.radius().is_finite() && scene.bounds.center().is_finite()) {
        return Err(PrepareError::Unbounded);
    }
    let done = AtomicUsize::new(0);
    let prepared: Vec<(Patch, Vec<DVec4>)> = (sources.par_iter())
        .map(|source| {
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            if count.is_multiple_of(PROGRESS_STEP) || count == sources.len() {
                progress(count, sources.len());
            }
            prepare_patch(source)
        })
        .collect();
    for (mut patch, points) in prepared {
        patch.points = scene.points.len()..scene.points.len() + points.len();
        scene.points.extend(points);
        scene.patches.push(patch);
    }
    Ok(scene)
}

/// A patch with what the model says of it.
struct Source<'a> {
    patch: &'a BezierPatch,
    domain: [[f64; 2]; 2],
    face: u32,
    trim: PatchTrim,
}

/// Lists a part's faces and what its loops leave of its patches, as `kept` says; returns the range of its patches.
fn collect_part<'a>(
    part: &'a Part,
    kept: &mut impl Iterator<Item = Option<PatchTrim>>,
    faces: &mut Vec<SceneFace>,
    sources: &mut Vec<Source<'a>>,
) -> Range<usize> {
    let start = sources.len();
    let sides = match part.solidity {
        Solidity::Solid => Sides::Outside,
        Solidity::Open => Sides::Both,
        // Which way a trimmed patch's border runs says nothing.
        Solidity::Unknown if part.faces.iter().any(|f| f.reversed || !f.loops.is_empty()) => Sides::Both,
        Solidity::Unknown => visible_sides(part),
    };
    for face in &part.faces {
        let Face { id, name, color, surface, loops, reversed, .. } = face;
        let sides = if *reversed { sides.turned() } else { sides };
        let number = faces.len() as u32;
        let (name, loops, color) = (name.clone(), loops.clone(), color.unwrap_or(DEFAULT_COLOR));
        faces.push(SceneFace { id: *id, name, color, sides, loops });
        let patches = surface.patches.iter().zip(kept.by_ref());
        sources.extend(
            patches
                .filter_map(|(p, trim)| Some(Source { patch: &p.patch, domain: p.domain, face: number, trim: trim? })),
        );
    }
    start..sources.len()
}

/// Moves a patch to its own origin and encloses its derivatives. The range of its points is still empty.
fn prepare_patch(source: &Source) -> (Patch, Vec<DVec4>) {
    let net = source.patch.net();
    let (low, high) = net.hull().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let origin = low * 0.5 + high * 0.5;
    // One rounding of the small result: models far from (0, 0, 0) keep what their file says.
    let local = |p: &DVec4| {
        DVec4::new(p.w.mul_add(-origin.x, p.x), p.w.mul_add(-origin.y, p.y), p.w.mul_add(-origin.z, p.z), p.w)
    };
    let points: Vec<DVec4> = net.points().iter().map(local).collect();
    let net = Net::new(net.degree(), &points);
    let patch = Patch {
        degree: net.degree(),
        points: 0..0,
        origin,
        face: source.face,
        domain: source.domain,
        rational: net.is_rational(),
        enclosure: enclose(net),
        cone: normal_cone(net),
        radius: radius(net),
        trim: source.trim,
    };
    (patch, points)
}
