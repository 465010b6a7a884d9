//! Which part of a face's patches is the face: its trim loops, and how far its measured gaps let it reach beyond them.

use super::region::Region;
use super::rim::{Passing, Rim, Sheet, SpaceRay};
use crate::scene::{Camera, Scene, SceneInstance};
use glam::{DAffine3, DVec2, DVec3};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A face reaches beyond its trims by its gap, in pixels at most this: two faces close a gap of a pixel.
pub(super) const WIDEST_REACH: f64 = 0.5;

/// The trims of all faces, each made ready when a ray first needs it.
#[derive(Debug)]
pub(super) struct Trims<'a> {
    scene: &'a Scene,
    faces: Vec<OnceLock<Box<Trimmed<'a>>>>,
    /// Patches by face: `patches[starts[f]..starts[f + 1]]`.
    starts: Vec<u32>,
    patches: Vec<u32>,
    parts: Vec<Part>,
    /// Of each instance, in `parts`.
    part_of: Vec<u32>,
    /// Largest gap of all curves, in the part's units.
    gap: f64,
    bytes: AtomicUsize,
}

#[derive(Debug)]
struct Trimmed<'a> {
    region: Region<'a>,
    rim: OnceLock<Rim<'a>>,
}

/// Patches that instances draw, with `[edge, face]` for each of their trim curves that has an edge, sorted.
#[derive(Debug)]
struct Part {
    patches: Range<usize>,
    edges: OnceLock<Vec<[u32; 2]>>,
}

/// A ray in the coordinates of an instance's part.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartRay {
    ray: SpaceRay,
    /// World units in one of the part's.
    scale: f64,
}

impl<'a> Trims<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let mut starts = vec![0_u32; scene.faces.len() + 1];
        for patch in &scene.patches {
            starts[patch.face as usize + 1] += 1;
        }
        for face in 1..starts.len() {
            starts[face] += starts[face - 1];
        }
        let mut next = starts.clone();
        let mut patches = vec![0; scene.patches.len()];
        for (number, patch) in (0..).zip(&scene.patches) {
            patches[next[patch.face as usize] as usize] = number;
            next[patch.face as usize] += 1;
        }
        let mut numbers = HashMap::new();
        let mut parts = Vec::new();
        let part_of = (scene.instances.iter())
            .map(|SceneInstance { patches, .. }| {
                *numbers.entry(patches.clone()).or_insert_with(|| {
                    parts.push(Part { patches: patches.clone(), edges: OnceLock::new() });
                    parts.len() as u32 - 1
                })
            })
            .collect();
        let curves = scene.faces.iter().flat_map(|f| f.loops.iter()).flat_map(|l| &l.curves);
        let gap = curves.map(|c| c.gap).fold(0.0, f64::max);
        let faces = scene.faces.iter().map(|_| OnceLock::new()).collect();
        Self { scene, faces, starts, patches, parts, part_of, gap, bytes: AtomicUsize::new(0) }
    }

    fn trimmed(&self, face: u32) -> Option<&Trimmed<'a>> {
        let loops = &self.scene.faces[face as usize].loops;
        if loops.is_empty() {
            return None;
        }
        let make = || {
            let region = Region::new(loops);
            self.bytes.fetch_add(size_of::<Trimmed>() + region.bytes(), Ordering::Relaxed);
            Box::new(Trimmed { region, rim: OnceLock::new() })
        };
        Some(self.faces[face as usize].get_or_init(make))
    }

    fn sheet(&self, face: u32) -> Sheet<'_> {
        let range = self.starts[face as usize] as usize..self.starts[face as usize + 1] as usize;
        Sheet { scene: self.scene, patches: &self.patches[range] }
    }

    /// The point of the parameter plane under (u, v) of a patch.
    pub fn plane_point(&self, patch: u32, [u, v]: [f64; 2]) -> DVec2 {
        let [along_u, along_v] = self.scene.patches[patch as usize].domain;
        let at = |[low, high]: [f64; 2], t: f64| low * (1.0 - t) + high * t;
        DVec2::new(at(along_u, u), at(along_v, v))
    }

    /// The patch and its parameter over a point of a face's plane.
    pub fn locate(&self, face: u32, p: DVec2) -> Option<(u32, [f64; 2])> {
        self.sheet(face).locate(p)
    }

    /// The face has loops.
    pub fn are_on(&self, face: u32) -> bool {
        !self.scene.faces[face as usize].loops.is_empty()
    }

    /// (u, v) of a patch is a point of its face.
    pub fn contain(&self, patch: u32, uv: [f64; 2]) -> bool {
        let face = self.scene.patches[patch as usize].face;
        self.trimmed(face).is_none_or(|trimmed| trimmed.region.contains(self.plane_point(patch, uv)))
    }

    /// Pixels by which faces may reach beyond their trims, at most, for this camera.
    pub fn widest_reach(&self, camera: &Camera) -> f64 {
        let scale = self.scene.instances.iter().map(|i| scale(&i.transform)).fold(0.0, f64::max);
        let pixels = self.gap * scale / camera.pixel_size(camera.near);
        // A gap that is not a number reaches as far as any.
        if pixels < WIDEST_REACH { pixels } else { WIDEST_REACH }
    }

    /// The ray through an image point; `None` where the instance has no inverse.
    pub fn ray(&self, camera: &Camera, instance: u32, point: DVec2) -> Option<PartRay> {
        let transform = &self.scene.instances[instance as usize].transform;
        let to_part = transform.inverse();
        let (origin, step) = camera.ray(point.x, point.y);
        let world = |c: DVec3| camera.right * c.x + camera.down * c.y + camera.forward * c.z;
        let origin = to_part.transform_point3(camera.eye + world(origin));
        let step = to_part.transform_vector3(world(step));
        let usable = origin.is_finite() && step.is_finite() && step.length() > 0.0;
        usable.then(|| PartRay { ray: SpaceRay { origin, step, near: camera.near }, scale: scale(transform) })
    }

    /// Where the ray passes near a face's trim curves: nearer than `reach(gap in world units, pixel size)`, in world
    /// units; every reach is at most `widest` pixels.
    pub fn passings(
        &self,
        camera: &Camera,
        ray: &PartRay,
        face: u32,
        widest: f64,
        reach: impl Fn(f64, f64) -> f64,
        mut found: impl FnMut(Passing),
    ) {
        let Some(trimmed) = self.trimmed(face) else { return };
        let sheet = self.sheet(face);
        let rim = trimmed.rim.get_or_init(|| {
            let rim = Rim::new(&sheet, &self.scene.faces[face as usize].loops);
            self.bytes.fetch_add(rim.bytes(), Ordering::Relaxed);
            rim
        });
        let far = camera.near + camera.extent;
        let widest = widest * camera.pixel_size(far) / ray.scale;
        let widest = widest.min(reach(rim.gap * ray.scale, camera.pixel_size(far)) / ray.scale);
        let reach = |gap: f64, z: f64| reach(gap * ray.scale, camera.pixel_size(z)) / ray.scale;
        rim.passings(&sheet, &ray.ray, widest, &reach, |p| {
            found(Passing { distance: p.distance * ray.scale, ..p });
        });
    }

    /// `[edge, face]` for each time that a face of the instance has this edge.
    pub fn faces_at(&self, instance: u32, edge: u32) -> &[[u32; 2]] {
        let part = &self.parts[self.part_of[instance as usize] as usize];
        let edges = part.edges.get_or_init(|| self.edges_of(&part.patches));
        let first = edges.partition_point(|&[e, _]| e < edge);
        let count = edges[first..].partition_point(|&[e, _]| e == edge);
        &edges[first..first + count]
    }

    fn edges_of(&self, patches: &Range<usize>) -> Vec<[u32; 2]> {
        let mut faces: Vec<u32> = self.scene.patches[patches.clone()].iter().map(|p| p.face).collect();
        faces.sort_unstable();
        faces.dedup();
        let curves = |face: u32| self.scene.faces[face as usize].loops.iter().flat_map(|l| &l.curves);
        let mut edges: Vec<_> =
            faces.into_iter().flat_map(|face| curves(face).filter_map(move |c| Some([c.edge?, face]))).collect();
        edges.sort_unstable();
        self.bytes.fetch_add(edges.capacity() * size_of::<[u32; 2]>(), Ordering::Relaxed);
        edges
    }

    /// Memory of what was made for rays so far.
    pub fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Drops what was made for rays.
    pub fn forget(&mut self) {
        for face in &mut self.faces {
            face.take();
        }
        for part in &mut self.parts {
            part.edges.take();
        }
        self.bytes = AtomicUsize::new(0);
    }
}

/// Of a transform: the cube root of what it does to volumes.
fn scale(transform: &DAffine3) -> f64 {
    transform.matrix3.determinant().abs().cbrt()
}
