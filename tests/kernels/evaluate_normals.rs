//! Points, tangents and normals by the kernels that no frame needs, against f64.

use crate::evaluate_scene::{bernstein, sum};
use crate::support::{Random, under_all_schedules};
use halfpixel::cuda::abi::{Point, SurfaceFrame, SurfacePoint};
use halfpixel::cuda::surfaces::Surfaces;
use halfpixel::cuda::{Pod, Shape};
use halfpixel::emulated::{Device, Schedule, TensorCores};

/// Across a patch: far from 1, so that scales are not taken for granted.
const SIZE: f64 = 300.0;

/// Largest errors: of positions over SIZE, of tangents over their length, of normals in radians.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    position: f64,
    tangent: f64,
    normal: f64,
}

impl Errors {
    fn max(self, other: Self) -> Self {
        Self {
            position: self.position.max(other.position),
            tangent: self.tangent.max(other.tangent),
            normal: self.normal.max(other.normal),
        }
    }

    fn within(self, other: Self) -> bool {
        self.position <= other.position && self.tangent <= other.tangent && self.normal <= other.normal
    }

    fn times(self, factor: f64) -> Self {
        Self { position: factor * self.position, tangent: factor * self.tangent, normal: factor * self.normal }
    }
}

/// Tangents are sums of differences of the net, about as large as it.
const PLAIN: Errors = Errors { position: 1e-3, tangent: 2e-2, normal: 2e-2 };
const SINGLE: Errors = Errors { position: 3e-7, tangent: 4e-6, normal: 4e-6 };

#[derive(Clone, Copy)]
struct Exact {
    position: [f64; 3],
    along: [[f64; 3]; 2],
    normal: [f64; 3],
}

struct Scene {
    surfaces: Surfaces,
    exact: Vec<Exact>,
}

impl Scene {
    /// Patches of these degrees, each in meshlets of all sizes.
    fn new(degrees: impl Iterator<Item = [usize; 2]>) -> Self {
        let mut scene = Self { surfaces: Surfaces::default(), exact: Vec::new() };
        let mut random = Random(11);
        for degree in degrees {
            let net = random_net(degree, &mut random);
            let points: Vec<Point> =
                (net.iter().map(|p| p.map(|c| c as f32))).map(|[x, y, z, w]| Point { x, y, z, w }).collect();
            let quads = [3 + 7 * random.below(2) as u16, 7 + random.below(3) as u16];
            let first = scene.surfaces.meshlets.len();
            scene.surfaces.push(&points, degree.map(|d| d as u8), quads);
            for m in &scene.surfaces.meshlets[first..] {
                for i in m.first[0]..=m.first[0] + u16::from(m.quads[0]) {
                    for j in m.first[1]..=m.first[1] + u16::from(m.quads[1]) {
                        let at = [f64::from(i) / f64::from(quads[0]), f64::from(j) / f64::from(quads[1])];
                        scene.exact.push(exact(&net, degree, at));
                    }
                }
            }
        }
        scene
    }

    fn run<T: Pod>(&self, device: &mut Device, kernel: &str, blocks: u32) -> Vec<T> {
        let (patches, meshlets) = (device.upload(&self.surfaces.patches), device.upload(&self.surfaces.meshlets));
        let (nets, basis) = (device.upload(&self.surfaces.nets), device.upload(&self.surfaces.basis));
        let (slopes, points) = (device.upload(&self.surfaces.slopes), device.allocate::<T>(self.surfaces.points));
        let count = self.surfaces.meshlets.len() as u32;
        let arguments = [
            &patches.pointer() as _,
            &meshlets.pointer() as _,
            &nets.pointer() as _,
            &basis.pointer() as _,
            &slopes.pointer() as _,
            &points.pointer() as _,
            &count as _,
        ];
        device.launch(kernel, Shape::row(blocks, 128), &arguments).expect("a launch");
        device.download(&points).expect("points")
    }

    fn errors_of_points(&self, device: &mut Device, kernel: &str) -> Errors {
        self.errors(&self.run::<SurfacePoint>(device, kernel, self.blocks()), |p| (p.position, None, p.normal))
    }

    fn errors_of_frames(&self, device: &mut Device, kernel: &str) -> Errors {
        let parts = |p: &SurfaceFrame| (p.position, Some([p.along_u, p.along_v]), p.normal);
        self.errors(&self.run::<SurfaceFrame>(device, kernel, self.blocks()), parts)
    }

    fn errors<T>(&self, found: &[T], parts: impl Fn(&T) -> ([f32; 3], Option<[[f32; 3]; 2]>, [f32; 3])) -> Errors {
        let mut errors = Errors::default();
        for (point, exact) in found.iter().zip(&self.exact) {
            let (position, along, normal) = parts(point);
            let tangent = along.map_or(0.0, |along| {
                let off = |k: usize| distance(along[k].map(f64::from), exact.along[k]) / length(exact.along[k]);
                off(0).max(off(1))
            });
            let position = distance(position.map(f64::from), exact.position) / SIZE;
            let normal = distance(normal.map(f64::from), exact.normal);
            assert!(position.is_finite() && normal.is_finite(), "a point was not written");
            errors = errors.max(Errors { position, tangent, normal });
        }
        errors
    }

    fn blocks(&self) -> u32 {
        self.surfaces.meshlets.len().div_ceil(4) as u32
    }
}

/// A lattice with bumps: tangents of about the patch's size, well apart.
fn random_net([m, n]: [usize; 2], random: &mut Random) -> Vec<[f64; 4]> {
    let mut net = Vec::new();
    for (i, j) in (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let mut along = |k: usize, degree: usize| SIZE * ((k as f64 + 0.2 * random.unit()) / degree as f64 - 0.5);
        let [x, y] = [along(i, m), along(j, n)];
        let z = 0.2 * SIZE * random.unit();
        let w = 2.0_f64.powf(random.unit());
        net.push([x * w, y * w, z * w, w]);
    }
    net
}

fn exact(net: &[[f64; 4]], [m, n]: [usize; 2], [u, v]: [f64; 2]) -> Exact {
    let [bu, bv] = [bernstein(m, u), bernstein(n, v)];
    let [x, y, z, w] = sum(net, &bu, &bv);
    let position = [x / w, y / w, z / w];
    let tangent = |[x, y, z, along_w]: [f64; 4]| -> [f64; 3] {
        std::array::from_fn(|c| ([x, y, z][c] - position[c] * along_w) / w)
    };
    let along = [tangent(sum(net, &slopes(m, u), &bv)), tangent(sum(net, &bu, &slopes(n, v)))];
    let [a, b] = along;
    let cross: [f64; 3] = std::array::from_fn(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3]);
    Exact { position, along, normal: cross.map(|c| c / length(cross)) }
}

fn slopes(degree: usize, t: f64) -> Vec<f64> {
    let lower = bernstein(degree - 1, t);
    let at = |i: usize| lower.get(i).copied().unwrap_or(0.0);
    (0..=degree).map(|i| degree as f64 * (at(i.wrapping_sub(1)) - at(i))).collect()
}

fn length(a: [f64; 3]) -> f64 {
    a.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    length(std::array::from_fn(|c| a[c] - b[c]))
}

fn all_degrees() -> impl Iterator<Item = [usize; 2]> {
    (0..49).map(|k| [1 + k / 7, 1 + k % 7])
}

/// Rows of a table: every kernel, with its largest errors over both models of tensor cores. Fails where they are too large.
pub fn rows() -> String {
    let scene = Scene::new(all_degrees());
    let frames = |kernel: &str| worst(|device| scene.errors_of_frames(device, kernel));
    let points = |kernel: &str| worst(|device| scene.errors_of_points(device, kernel));
    let single = frames("evaluate_tangents_f32").max(points("evaluate_normals_f32"));
    assert!(single.within(SINGLE), "{single:?}");
    let mut rows = row("evaluate_normals_f32, evaluate_tangents_f32", single);
    let eter = points("evaluate_eter");
    assert!(eter.within(single.times(2.0)), "{eter:?}, f32 {single:?}");
    rows += &row("evaluate_eter", eter);
    for name in ["f16", "tf32"] {
        let plain = points(&format!("evaluate_normals_{name}"));
        assert!(plain.within(PLAIN), "{name}: {plain:?}");
        rows += &row(&format!("evaluate_normals_{name}"), plain);
        let recovered = points(&format!("evaluate_normals_{name}_recovered"));
        assert!(recovered.within(single.times(2.0)), "{name}: {recovered:?}, f32 {single:?}");
        rows += &row(&format!("evaluate_normals_{name}_recovered"), recovered);
    }
    let sparse = points("evaluate_normals_f16_sparse");
    assert!(sparse.within(PLAIN), "{sparse:?}");
    rows += &row("evaluate_normals_f16_sparse", sparse);
    let recovered = frames("evaluate_tangents_f16_recovered");
    assert!(recovered.within(single.times(2.0)), "{recovered:?}, f32 {single:?}");
    rows + &row("evaluate_tangents_f16_recovered", recovered)
}

fn worst(errors: impl Fn(&mut Device) -> Errors) -> Errors {
    let of = |tensor_cores| errors(&mut Device::new(Schedule { tensor_cores, ..Schedule::default() }, 2));
    of(TensorCores::Sm80).max(of(TensorCores::Sm90))
}

fn row(kernel: &str, errors: Errors) -> String {
    let tangent = if errors.tangent > 0.0 { format!("{:.1e}", errors.tangent) } else { "".into() };
    format!("| {kernel} | {:.1e} | {tangent} | {:.1e} |\n", errors.position, errors.normal)
}

#[test]
fn unrolled_kernels_are_as_exact() {
    for degree in 3..=7 {
        let scene = Scene::new((0..6).map(|_| [degree; 2]));
        for name in ["evaluate_normals_f32", "evaluate_eter"] {
            let found = scene.errors_of_points(&mut Device::default(), &format!("{name}_d{degree}"));
            assert!(found.within(SINGLE), "{name}_d{degree}: {found:?}");
        }
    }
}

#[test]
fn normals_come_out_alike_in_any_order() {
    let scene = Scene::new([[3, 3], [2, 5], [7, 1]].into_iter());
    let kernels = ["evaluate_normals_f32", "evaluate_eter", "evaluate_normals_f16_recovered"];
    // ETER's threads persist: one block takes all meshlets.
    for (kernel, blocks) in kernels.map(|kernel| (kernel, scene.blocks())).into_iter().chain([("evaluate_eter", 1)]) {
        let found = under_all_schedules(|device| scene.run::<SurfacePoint>(device, kernel, blocks));
        let errors = scene.errors(&found, |p| (p.position, None, p.normal));
        assert!(errors.within(SINGLE.times(2.0)), "{kernel}: {errors:?}");
    }
}
