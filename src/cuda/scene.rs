//! A scene in a device's memory, for `kernels/scene.cuh`: uploaded once, drawn from every side.

use super::gpu::pods;
use super::trims::{TrimPointers, TrimsOnDevice};
use super::{Buffer, Gpu, GpuError, Pointer, abi};
use crate::scene::{Patch, Scene, SceneInstance, Sides};

/// What cull and estimate read of a scene.
#[derive(Clone, Copy, Debug)]
pub struct SceneOnDevice {
    patches: Buffer<abi::ScenePatch>,
    points: Buffer<abi::ControlPoint>,
    instances: Buffer<abi::SceneInstance>,
    faces: Buffer<abi::FaceColor>,
    colors: Buffer<abi::FaceColor>,
    trims: TrimsOnDevice,
    /// Patches of all instances.
    pub(crate) items: u32,
    /// Trim curves cut some patch.
    pub(crate) trimmed: bool,
    /// Largest degree in one direction, and most control points of a patch.
    pub(crate) degree: usize,
    pub(crate) most_points: usize,
    /// Numbers in f64 that a warp needs to halve any of its patches and enclose the halves.
    pub(crate) memory: usize,
}

/// What kernels get of it: `scene::Scene`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ScenePointers {
    patches: Pointer<abi::ScenePatch>,
    points: Pointer<abi::ControlPoint>,
    instances: Pointer<abi::SceneInstance>,
    faces: Pointer<abi::FaceColor>,
    colors: Pointer<abi::FaceColor>,
    trims: TrimPointers,
}

pods!(abi::ScenePatch abi::ControlPoint abi::SceneInstance abi::FaceColor ScenePointers);

impl SceneOnDevice {
    pub fn upload<G: Gpu>(gpu: &mut G, scene: &Scene) -> Result<Self, GpuError> {
        let patches: Vec<_> = scene.patches.iter().map(|p| patch(scene, p)).collect();
        let points: Vec<_> =
            scene.points.iter().map(|p| abi::ControlPoint { x: p.x, y: p.y, z: p.z, w: p.w }).collect();
        let faces = scene.faces.iter().enumerate().map(|(k, f)| abi::FaceColor { face: k as u32, color: f.color });
        let own = scene.instances.iter().flat_map(|i| &i.face_colors);
        let colors: Vec<_> = own.map(|&(face, color)| abi::FaceColor { face, color }).collect();
        let items = places("patches of all instances", scene.instances.iter().map(|i| i.patches.len()).sum())?;
        places("control points", points.len())?;
        places("colours of faces of all instances", colors.len())?;
        let (mut first_item, mut first_color, mut instances) = (0, 0, Vec::with_capacity(scene.instances.len()));
        for place in &scene.instances {
            instances.push(abi::SceneInstance { first_item, first_color, ..instance(place) });
            first_item += place.patches.len() as u32;
            first_color += place.face_colors.len() as u32;
        }
        Ok(Self {
            patches: gpu.upload(&patches)?,
            points: gpu.upload(&points)?,
            instances: gpu.upload(&instances)?,
            faces: gpu.upload(&faces.collect::<Vec<_>>())?,
            colors: gpu.upload(&colors)?,
            trims: TrimsOnDevice::upload(gpu, &scene.trims)?,
            items,
            trimmed: scene.patches.iter().any(|p| p.trim.tree.is_some()),
            degree: scene.patches.iter().flat_map(|p| p.degree).max().unwrap_or(1),
            most_points: scene.patches.iter().map(|p| p.points.len()).max().unwrap_or(1),
            memory: scene.patches.iter().map(|p| memory(scene, p)).max().unwrap_or(0),
        })
    }

    /// What a kernel gets.
    pub fn pointers(&self) -> ScenePointers {
        ScenePointers {
            patches: self.patches.pointer(),
            points: self.points.pointer(),
            instances: self.instances.pointer(),
            faces: self.faces.pointer(),
            colors: self.colors.pointer(),
            trims: self.trims.pointers(),
        }
    }

    pub(crate) fn trims(&self) -> TrimPointers {
        self.trims.pointers()
    }

    pub(crate) fn instances(&self) -> u32 {
        self.instances.len() as u32
    }

    pub fn free<G: Gpu>(self, gpu: &mut G) -> Result<(), GpuError> {
        gpu.free(self.patches)?;
        gpu.free(self.points)?;
        gpu.free(self.instances)?;
        gpu.free(self.faces)?;
        gpu.free(self.colors)?;
        self.trims.free(gpu)
    }
}

/// Places in a list have 32 bits.
fn places(what: &'static str, count: usize) -> Result<u32, GpuError> {
    let limit = u32::MAX.into();
    u32::try_from(count).map_err(|_| GpuError::TooMany { what, needed: count as u64, limit })
}

/// Where the colours and the items of an instance begin is not known here.
fn instance(instance: &SceneInstance) -> abi::SceneInstance {
    let SceneInstance { patches, transform, color, face_colors, .. } = instance;
    abi::SceneInstance {
        matrix: transform.matrix3.to_cols_array_2d(),
        translation: transform.translation.to_array(),
        first_patch: patches.start as u32,
        colors: face_colors.len() as u32,
        color: color.unwrap_or_default(),
        has_color: color.is_some().into(),
        ..abi::SceneInstance::default()
    }
}

fn patch(scene: &Scene, patch: &Patch) -> abi::ScenePatch {
    let sides = match scene.faces[patch.face as usize].sides {
        Sides::Both => abi::SIDES_BOTH,
        Sides::Outside => abi::SIDES_OUTSIDE,
        Sides::Inside => abi::SIDES_INSIDE,
    };
    abi::ScenePatch {
        points: patch.points.start as u32,
        degree: patch.degree.map(|d| d as u8),
        sides: sides as u8,
        rational: patch.rational.into(),
        face: patch.face,
        tree: patch.trim.tree.unwrap_or(abi::NO_TREE),
        origin: patch.origin.to_array(),
        cone_axis: patch.cone.axis.to_array(),
        cone_cos: patch.cone.cos_angle,
        radius: patch.radius,
        domain: patch.domain,
        enclosure_low: patch.enclosure.low.map(|v| v.to_array()),
        enclosure_high: patch.enclosure.high.map(|v| v.to_array()),
        enclosure_radius: patch.enclosure.radius,
        gap: patch.trim.gap,
        rim: patch.trim.rim.into(),
        unused: [0; 3],
    }
}

/// Two nets that are halved in turn, and what kernels/enclosure.cuh takes: three nets of second differences, or, where any
/// weight differs, the polynomials of the quotient rule and three nets of thrice the degree.
fn memory(scene: &Scene, patch: &Patch) -> usize {
    let points = &scene.points[patch.points.clone()];
    let even = |numbers: usize| numbers.next_multiple_of(2);
    let enclosing = if points.iter().all(|p| p.w == points[0].w) {
        12 * points.len()
    } else {
        let room: usize = patch.degree.iter().map(|d| 3 * d + 1).product();
        even(3 * points.len()) + 3 * even(points.len()) + 2 * even(room) + 3 * even(3 * room) + 4 + 12 * room
    };
    8 * points.len() + enclosing
}
