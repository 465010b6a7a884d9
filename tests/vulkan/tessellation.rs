//! Evaluation by fixed-function tessellation: the CPU's vertices, and those of f64.

use crate::skip;
use halfpixel::cuda::abi;
use halfpixel::cuda::surfaces::Surfaces;
use halfpixel::import;
use halfpixel::scene::{Scene, ViewSpec, prepare};
use halfpixel::stages::{Options, Renderer, Trim};
use halfpixel::vulkan::{
    Borders, Device, EdgeFactors, Evaluated, Parameters, Piece, Sample, Tessellated, Tessellation, Tessellator,
    Validation, VulkanError, with_factor,
};
use std::collections::{BTreeMap, HashMap};

const SIZE: [u32; 2] = [200, 150];

fn tessellator() -> Option<Tessellator> {
    let made = Device::new(Validation::On, None).and_then(Tessellator::new);
    made.inspect_err(skip).ok()
}

fn assert_silent(tessellator: &Tessellator) {
    let messages = tessellator.device().messages();
    assert!(messages.is_empty(), "{messages:#?}");
}

fn scene(name: &str) -> Scene {
    prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene")
}

/// Net, derivatives along u and along v, in f64.
fn exact(net: &[abi::Point], degree: [u8; 2], at: [f64; 2]) -> [[f64; 4]; 3] {
    let [m, n] = degree.map(usize::from);
    let ([bu, du], [bv, dv]) = (bernstein(m, at[0]), bernstein(n, at[1]));
    let sum = |along_u: &[f64], along_v: &[f64]| {
        let mut sum = [0.0; 4];
        for (k, p) in net.iter().enumerate() {
            let b = along_u[k / (n + 1)] * along_v[k % (n + 1)];
            [p.x, p.y, p.z, p.w].into_iter().zip(&mut sum).for_each(|(c, s)| *s += b * f64::from(c));
        }
        sum
    };
    [sum(&bu, &bv), sum(&du, &bv), sum(&bu, &dv)]
}

/// Bernstein values and their derivatives.
fn bernstein(n: usize, t: f64) -> [Vec<f64>; 2] {
    let row = |n: usize| {
        let choose = |i: usize| (0..i).fold(1.0, |c, k| c * (n - k) as f64 / (k + 1) as f64);
        (0..=n).map(|i| choose(i) * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32)).collect::<Vec<f64>>()
    };
    let lower = row(n - 1);
    let at = |i: usize| lower.get(i).copied().unwrap_or(0.0);
    [row(n), (0..=n).map(|i| n as f64 * (at(i.wrapping_sub(1)) - at(i))).collect()]
}

/// The direction of S_u x S_v, and how well it is known: the angle between the tangents times the ratio of their lengths.
fn normal([p, u, v]: [[f64; 4]; 3]) -> ([f64; 3], f64) {
    let tangent = |d: [f64; 4]| [0, 1, 2].map(|k| d[k] - p[k] / p[3] * d[3]);
    let length = |a: [f64; 3]| a.iter().map(|c| c * c).sum::<f64>().sqrt();
    let (u, v) = (tangent(u), tangent(v));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let size = length(n);
    (n.map(|c| c / size), size / length(u).max(length(v)).powi(2))
}

/// Samples by patch and grid place. All have been written; those off the grid (a strip's middle) are left out.
fn by_place(found: &Tessellated, patches: &[abi::Patch]) -> HashMap<(u32, [u32; 2]), Sample> {
    let mut places = HashMap::new();
    for (k, piece) in found.pieces.iter().enumerate() {
        let quads = patches[piece.patch as usize].quads;
        for sample in found.samples(k) {
            let all = sample.position.iter().chain(&sample.normal).chain(&sample.parameters);
            assert!(all.copied().all(f32::is_finite), "a vertex was never asked for: {piece:?} {sample:?}");
            let line = [0, 1].map(|axis| sample.parameters[axis] * f32::from(quads[axis]));
            if line.iter().all(|l| (l - l.round()).abs() < 1e-3) {
                places.insert((piece.patch, line.map(|l| l.round() as u32)), *sample);
            }
        }
    }
    places
}

fn input<'a>(view: &'a abi::View, patches: &'a [abi::Patch], nets: &'a [abi::Point]) -> Tessellation<'a> {
    let (factors, parameters) = (EdgeFactors::Own, Parameters::Exact);
    Tessellation { size: SIZE, view, patches, nets, factors, parameters }
}

#[test]
fn vertices_are_those_of_the_cpu() {
    let Some(mut tessellator) = tessellator() else { return };
    let options = Options { trim: Trim::Off, ..Options::default() };
    let orthographic = ViewSpec { size: SIZE, orthographic: true, ..ViewSpec::default() };
    let close = ViewSpec { size: SIZE, zoom: 40.0, ..ViewSpec::default() };
    let whole = ViewSpec { size: SIZE, ..ViewSpec::default() };
    for (name, view) in [("teapot", whole), ("teapot", orthographic), ("sphere", close), ("stress", whole)] {
        let scene = scene(&format!("builtin:{name}"));
        let camera = view.camera(&scene.bounds).expect("a camera");
        let (staged, vertices) = Renderer::new(&scene).staged(&camera, &options).expect("a frame");
        let found = tessellator.evaluate(&input(&staged.view, &staged.patches, &staged.nets)).expect("vertices");
        let places = by_place(&found, &staged.patches);
        for meshlet in &staged.meshlets {
            let patch = &staged.patches[meshlet.patch as usize];
            let points: usize = patch.degree.iter().map(|&d| usize::from(d) + 1).product();
            let net = &staged.nets[patch.net as usize..][..points];
            let across = usize::from(meshlet.quads[1]) + 1;
            for k in 0..(usize::from(meshlet.quads[0]) + 1) * across {
                let line = [k / across, k % across];
                let line = [0, 1].map(|axis| u32::from(meshlet.first[axis]) + line[axis] as u32);
                let vertex = &vertices[meshlet.vertices as usize + k];
                let sample = places.get(&(meshlet.patch, line)).expect("every vertex of the grid");
                // Snapping, and roundings of both.
                let off = 0.5 + 2.0 * 256.0 * patch.rounding;
                let at = [0, 1]
                    .map(|axis| sample.position[axis] * 256.0 - ([vertex.x, vertex.y][axis] - patch.base[axis]) as f32);
                assert!(at.iter().all(|d| d.abs() <= off), "{name} {line:?} of {:?}: {at:?} > {off}", patch.quads);
                let depth = (sample.position[2] - vertex.depth).abs();
                assert!(depth <= 2e-6, "{name}: depth {} and {}", sample.position[2], vertex.depth);
                let parameters = [0, 1].map(|axis| f64::from(line[axis]) / f64::from(patch.quads[axis]));
                check_normal(sample, exact(net, patch.degree, parameters));
            }
        }
    }
    assert_silent(&tessellator);
}

fn check_normal(sample: &Sample, jet: [[f64; 4]; 3]) {
    let (expected, size) = normal(jet);
    // Nothing is known where tangents are parallel, or one vanishes.
    if size > 1e-2 {
        let off = [0, 1, 2].map(|k| (f64::from(sample.normal[k]) - expected[k]).abs());
        assert!(off.iter().all(|o| *o < 2e-4 / size), "normal {:?}, {expected:?}", sample.normal);
    }
}

/// Patches of a list of degrees and quads: bumpy lattices, 100 px across, with weights.
fn bumpy(all: &[([u8; 2], [u16; 2])]) -> Surfaces {
    let mut surfaces = Surfaces::default();
    for (number, &(degree, quads)) in all.iter().enumerate() {
        let [m, n] = degree.map(usize::from);
        let point = |k: usize| {
            let (i, j) = (k / (n + 1), k % (n + 1));
            let bump = |s: usize| ((k * 7 + number * 13 + s) as f32 * 12.9898).sin();
            let w = 1.0 + 0.5 * bump(3);
            let [x, y] = [i as f32 / m as f32 - 0.5, j as f32 / n as f32 - 0.5];
            abi::Point {
                x: w * (100.0 * x + 4.0 * bump(0)),
                y: w * (100.0 * y + 4.0 * bump(1)),
                z: 20.0 * w * bump(2),
                w,
            }
        };
        let net: Vec<abi::Point> = (0..(m + 1) * (n + 1)).map(point).collect();
        surfaces.push(&net, degree, quads);
    }
    surfaces
}

#[test]
fn all_degrees_and_grids_are_evaluated() {
    let Some(mut tessellator) = tessellator() else { return };
    let kinds = [
        // More than the hardware's largest level, strips, single quads.
        ([3, 3], [150, 3]),
        ([3, 3], [3, 200]),
        ([2, 3], [65, 64]),
        ([3, 2], [5, 1]),
        ([1, 1], [1, 1]),
        ([4, 1], [1, 9]),
        ([5, 6], [8, 8]),
        ([7, 7], [9, 4]),
        ([7, 1], [2, 2]),
        // Beyond the paper's.
        ([9, 12], [6, 5]),
    ];
    let surfaces = bumpy(&kinds);
    let view = abi::View { depth_slope: 0.01, ..abi::View::default() };
    let list = input(&view, &surfaces.patches, &surfaces.nets);
    let found = tessellator.evaluate(&list).expect("vertices");
    assert!(found.pieces.iter().all(|p| p.levels().iter().all(|&level| level <= 64)));
    let places = by_place(&found, &surfaces.patches);
    let expected: usize = kinds.iter().map(|(_, [u, v])| (usize::from(*u) + 1) * (usize::from(*v) + 1)).sum();
    assert_eq!(places.len(), expected);
    for (&(number, line), sample) in &places {
        check_sample(&surfaces, number as usize, sample, line);
    }
    // The hardware's own parameters are about as good as their 16 bits.
    let rough = tessellator.evaluate(&Tessellation { parameters: Parameters::Hardware, ..list }).expect("vertices");
    for (number, (a, b)) in
        (0..found.pieces.len()).flat_map(|k| found.samples(k).iter().zip(rough.samples(k))).enumerate()
    {
        let off = [0, 1].map(|axis| (a.position[axis] - b.position[axis]).abs());
        assert!(off.iter().all(|&o| o < 0.02), "{number}: {a:?}, {b:?}");
    }
    assert_silent(&tessellator);
}

fn check_sample(surfaces: &Surfaces, number: usize, sample: &Sample, line: [u32; 2]) {
    let patch = &surfaces.patches[number];
    let at = [0, 1].map(|axis| f64::from(line[axis]) / f64::from(patch.quads[axis]));
    let near = [0, 1].map(|axis| (f64::from(sample.parameters[axis]) - at[axis]).abs());
    assert!(near.iter().all(|&d| d <= 1.2e-7), "parameters {:?} of {line:?}", sample.parameters);
    let points: usize = patch.degree.iter().map(|&d| usize::from(d) + 1).product();
    let jet = exact(&surfaces.nets[patch.net as usize..][..points], patch.degree, at);
    let off = [0, 1].map(|k| (f64::from(sample.position[k]) - jet[0][k] / jet[0][3]).abs());
    // 100 px across: some units of 2^-23 of that.
    assert!(off.iter().all(|&o| o < 2e-4), "{:?} {line:?}: {off:?} px", patch.degree);
    check_normal(sample, jet);
}

/// Pixels along a patch's side in parameter order, and the number of quads.
fn border(found: &Tessellated, patch: &abi::Patch, number: u32, side: usize) -> Vec<[f32; 2]> {
    let (across, along) = (side / 2, 1 - side / 2);
    let at_end = |p: &Piece| {
        let end = if side.is_multiple_of(2) { 0 } else { p.whole[across] - p.size[across] };
        p.patch == number && p.low[across] == end
    };
    let mut pieces: Vec<usize> = (0..found.pieces.len()).filter(|&k| at_end(&found.pieces[k])).collect();
    pieces.sort_by_key(|&k| found.pieces[k].low[along]);
    let mut all: Vec<[f32; 2]> = Vec::new();
    for k in pieces {
        let samples = &found.side(k, side)[usize::from(!all.is_empty())..];
        all.extend(samples.iter().map(|s| [0, 1].map(|axis| s.position[axis] + patch.base[axis] as f32 / 256.0)));
    }
    all
}

fn apart<'a>(a: impl Iterator<Item = &'a [f32; 2]>, b: impl Iterator<Item = &'a [f32; 2]>) -> f32 {
    a.zip(b).map(|(a, b)| (a[0] - b[0]).abs().max((a[1] - b[1]).abs())).fold(0.0, f32::max)
}

#[test]
fn shared_borders_have_the_same_vertices() {
    let Some(mut tessellator) = tessellator() else { return };
    let scene = scene("builtin:teapot");
    let borders = Borders::new(&scene);
    for zoom in [1.0, 12.0] {
        let camera = ViewSpec { size: SIZE, zoom, ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
        let options = Options { tolerance: 0.02, trim: Trim::Off, ..Options::default() };
        let (staged, _) = Renderer::new(&scene).staged(&camera, &options).expect("a frame");
        let names = borders.sides(&staged.patches, &staged.leaves);
        let mut shared: BTreeMap<u32, Vec<(u32, usize)>> = BTreeMap::new();
        for (k, names) in names.iter().enumerate() {
            names.iter().enumerate().for_each(|(side, name)| shared.entry(*name).or_default().push((k as u32, side)));
        }
        shared.retain(|_, ends| ends.len() > 1);
        assert!(shared.len() > staged.patches.len() / 2, "{} of {} patches", shared.len(), staged.patches.len());
        let own = |&(patch, side): &(u32, usize)| staged.patches[patch as usize].quads[1 - side / 2];
        assert!(shared.values().any(|ends| own(&ends[0]) != own(&ends[1])), "factors that differ");
        let list = input(&staged.view, &staged.patches, &staged.nets);
        let list = Tessellation { factors: EdgeFactors::Shared(&names), ..list };
        let found = tessellator.evaluate(&list).expect("vertices");
        for ends in shared.values() {
            let line = |&(number, side): &(u32, usize)| border(&found, &staged.patches[number as usize], number, side);
            let first = line(&ends[0]);
            let quads = ends.iter().map(|end| usize::from(own(end))).max().expect("two");
            assert!(first.len() > quads, "{} vertices for {quads} quads", first.len());
            for end in &ends[1..] {
                let other = line(end);
                assert_eq!(first.len(), other.len(), "{ends:?}");
                let off = apart(first.iter(), other.iter()).min(apart(first.iter(), other.iter().rev()));
                let roundings: f32 = [ends[0], *end].iter().map(|(k, _)| staged.patches[*k as usize].rounding).sum();
                assert!(off <= 2.0 * roundings, "{ends:?}: {off} px > 2 x {roundings}");
            }
        }
    }
    assert_silent(&tessellator);
}

#[test]
fn mesh_shaders_emit_what_was_evaluated() {
    let Some(mut tessellator) = tessellator() else { return };
    let surfaces = bumpy(&[([3, 3], [12, 9]), ([2, 2], [1, 7])]);
    let place = |k: usize| abi::SurfacePoint { position: [k as f32, 2.0 * k as f32, 0.5], normal: [0.0, 0.6, 0.8] };
    let points: Vec<abi::SurfacePoint> = (0..40).map(place).collect();
    let (patches, meshlets) = (&surfaces.patches, &surfaces.meshlets);
    let input = Evaluated { size: SIZE, patches, meshlets, points: &points };
    let emitted = tessellator.emit(&input).expect("vertices");
    let expected: Vec<_> = points.iter().cycle().take(surfaces.points).copied().collect();
    assert_eq!(emitted, expected);
    let ms = tessellator.time_meshlets(&input, 3).expect("a time");
    assert!(ms.min > 0.0 && ms.min <= ms.median && ms.median <= ms.max, "{ms:?}");
    assert_silent(&tessellator);
}

#[test]
fn times_are_those_of_the_device() {
    let Some(mut tessellator) = tessellator() else { return };
    let surfaces = bumpy(&[([3, 3], [8, 8]), ([7, 7], [8, 8])]);
    let patches = with_factor(&surfaces.patches, 64);
    let view = abi::View::default();
    // Two degrees, two pipelines; what they take is nobody's business here.
    for parameters in [Parameters::Exact, Parameters::Hardware] {
        let list = Tessellation { parameters, ..input(&view, &patches, &surfaces.nets) };
        let ms = tessellator.time(&list, 2).expect("a time");
        assert!(ms.min > 0.0 && ms.min <= ms.median && ms.median <= ms.max, "{ms:?}");
    }
    assert_silent(&tessellator);
}

#[test]
fn what_cannot_be_tessellated_is_refused() {
    let Some(mut tessellator) = tessellator() else { return };
    let surfaces = bumpy(&[([3, 3], [2, 2]), ([3, 3], [2, 2])]);
    let view = abi::View::default();
    let refused = |tessellator: &mut Tessellator, patches: &[abi::Patch], factors| {
        tessellator.evaluate(&Tessellation { factors, ..input(&view, patches, &surfaces.nets) }).expect_err("refused")
    };
    let change = |change: fn(&mut abi::Patch)| {
        let mut patches = surfaces.patches.clone();
        change(&mut patches[1]);
        patches
    };
    for patches in [change(|p| p.quads[0] = 0), change(|p| p.degree[1] = 0), change(|p| p.net += 1)] {
        let error = refused(&mut tessellator, &patches, EdgeFactors::Own);
        assert!(matches!(error, VulkanError::BadPatch { patch: 1, .. }), "{error}");
    }
    let error = refused(&mut tessellator, &surfaces.patches, EdgeFactors::Shared(&[[0, 1, 2, 3]]));
    assert!(matches!(error, VulkanError::BadPatch { patch: 1, .. }), "{error}");
    let meshlet = [abi::Meshlet { patch: 2, quads: [1, 1], ..abi::Meshlet::default() }];
    let input = Evaluated { size: SIZE, patches: &surfaces.patches, meshlets: &meshlet, points: &[] };
    let error = tessellator.emit(&input).expect_err("refused");
    assert!(matches!(error, VulkanError::BadMeshlet { meshlet: 0, .. }), "{error}");
    let empty = tessellator.evaluate(&Tessellation { patches: &[], ..self::input(&view, &[], &[]) }).expect("nothing");
    assert!(empty.pieces.is_empty());
    assert_silent(&tessellator);
}
