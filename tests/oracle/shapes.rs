//! Exact rational surfaces, scenes of them, cameras and random numbers.

use glam::{DAffine3, DVec3, DVec4};
use halfpixel::scene::{
    Bounds, Camera, Enclosure, NormalCone, Patch, Projection, Scene, SceneFace, SceneInstance, Sides, ViewSpec,
};

/// A net and the face it belongs to.
pub struct Part {
    pub degree: [usize; 2],
    pub points: Vec<DVec4>,
    pub face: u32,
}

impl Part {
    pub fn new(degree: [usize; 2], points: Vec<DVec4>, face: u32) -> Self {
        Self { degree, points, face }
    }
}

/// A scene of one instance that draws all parts, about local origins at their first control point.
pub fn scene(parts: &[Part], offset: DVec3) -> Scene {
    let mut scene = Scene::default();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for part in parts {
        let start = scene.points.len();
        let origin = part.points[0].truncate() / part.points[0].w;
        for q in &part.points {
            let at = q.truncate() / q.w;
            (low, high) = (low.min(at), high.max(at));
            scene.points.push((q.truncate() - origin * q.w).extend(q.w));
        }
        scene.patches.push(Patch {
            degree: part.degree,
            points: start..scene.points.len(),
            origin: origin + offset,
            face: part.face,
            domain: [[0.0, 1.0]; 2],
            rational: true,
            enclosure: Enclosure::default(),
            cone: NormalCone { axis: DVec3::Z, cos_angle: -1.0 },
            radius: f64::INFINITY,
            trim: Default::default(),
        });
    }
    let faces = parts.iter().map(|p| p.face).max().unwrap_or(0) + 1;
    scene.faces = (0..faces)
        .map(|id| SceneFace { id, name: "".into(), color: [0.5; 3], sides: Sides::Both, loops: [].into() })
        .collect();
    scene.instances = vec![SceneInstance {
        name: String::new(),
        patches: 0..parts.len(),
        transform: DAffine3::IDENTITY,
        color: None,
        face_colors: Vec::new(),
    }];
    scene.bounds = Bounds { low: low + offset, high: high + offset };
    scene
}

pub fn camera(scene: &Scene, size: [u32; 2], orthographic: bool) -> Camera {
    ViewSpec { size, orthographic, ..ViewSpec::default() }.camera(&scene.bounds).unwrap()
}

/// A ray's points in the world: `origin + depth * step`.
pub fn ray(camera: &Camera, x: f64, y: f64) -> (DVec3, DVec3) {
    let world = |c: DVec3| camera.right * c.x + camera.down * c.y + camera.forward * c.z;
    let (origin, step) = camera.ray(x, y);
    (camera.eye + world(origin), world(step))
}

pub fn project(camera: &Camera, world: DVec3) -> glam::DVec2 {
    camera.project(camera.to_camera(world))
}

/// Quarter of the unit circle as (x, y, w), from angle `quarter` * 90°.
fn quarter_circle(quarter: usize) -> [[f64; 3]; 3] {
    let (c, s) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][quarter];
    let w = 0.5_f64.sqrt();
    [[c, s, 1.0], [(c - s) * w, (s + c) * w, w], [-s, c, 1.0]]
}

/// The profile (radius, height, weight) turned about z, four patches, all of one face.
fn revolved(profile: &[[f64; 3]]) -> Vec<Part> {
    (0..4)
        .map(|quarter| {
            let circle = quarter_circle(quarter);
            let points = circle
                .iter()
                .flat_map(|&[x, y, w]| {
                    profile.iter().map(move |&[r, z, pw]| DVec4::new(r * x * pw, r * y * pw, z * w * pw, w * pw))
                })
                .collect();
            Part::new([2, profile.len() - 1], points, 0)
        })
        .collect()
}

/// Homogeneous revolution needs profile points with their radius divided by the weight; this does that for arcs.
fn arc_profile(quarter: usize, center: f64, radius: f64) -> Vec<[f64; 3]> {
    quarter_circle(quarter).iter().map(|&[x, z, w]| [center + radius * x / w, radius * z / w, w]).collect()
}

pub fn sphere(radius: f64) -> Vec<Part> {
    [0, 3].into_iter().flat_map(|quarter| revolved(&arc_profile(quarter, 0.0, radius))).collect()
}

pub fn torus(major: f64, minor: f64) -> Vec<Part> {
    (0..4).flat_map(|quarter| revolved(&arc_profile(quarter, major, minor))).collect()
}

/// Open, radius 1, from z = -1 to 1.
pub fn cylinder() -> Vec<Part> {
    revolved(&[[1.0, -1.0, 1.0], [1.0, 1.0, 1.0]])
}

/// A parallelogram.
pub fn plane(corner: DVec3, u: DVec3, v: DVec3, face: u32) -> Part {
    let points = [corner, corner + v, corner + u, corner + u + v].map(|p| p.extend(1.0));
    Part::new([1, 1], points.to_vec(), face)
}

/// A random rational patch over a bumpy unit square; weights between `1 / spread` and `spread`.
pub fn random_patch(random: &mut Random, degree: [usize; 2], bump: f64, spread: f64) -> Part {
    let mut points = Vec::new();
    for i in 0..=degree[0] {
        for j in 0..=degree[1] {
            let at = DVec3::new(i as f64 / degree[0] as f64, j as f64 / degree[1] as f64, 0.0);
            let noise = DVec3::new(random.signed(), random.signed(), random.signed()) * bump;
            let w = spread.powf(random.signed());
            points.push(((at + noise) * w).extend(w));
        }
    }
    Part::new(degree, points, 0)
}

/// A small linear congruential generator (Knuth's MMIX constants).
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
}

/// An orthographic camera that looks along +y at the x-z plane, with world point 0 in the middle of the image.
pub fn front(size: [u32; 2], scale: f64) -> Camera {
    Camera {
        size,
        eye: DVec3::new(0.0, -100.0, 0.0),
        right: DVec3::X,
        down: -DVec3::Z,
        forward: DVec3::Y,
        projection: Projection::Orthographic { scale },
        near: 1.0,
        extent: 200.0,
    }
}
