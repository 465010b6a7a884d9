//! Evaluation on tensor cores against f64 and against the f32 kernel.

use crate::evaluate_bounds::tightness;
use crate::evaluate_normals;
use crate::evaluate_scene::{Errors, Kind, Scene};
use crate::fresh::{agrees, root};
use crate::support::under_all_schedules;
use halfpixel::cuda::abi::Vertex;
use halfpixel::cuda::precision::Arithmetic;
use halfpixel::emulated::{Device, Schedule, TensorCores};
use std::fs;

const TABLE: &str = "bench/results/evaluate-precisions.md";
const F32: &str = "evaluate_f32";

/// Kernels on tensor cores, and m16n8k8 products a meshlet (sparse: m16n8k16); tests/kernel_resources counts them in the machine code.
const ARITHMETICS: [(Arithmetic, u32); 5] = [
    (Arithmetic::F16, 6),
    (Arithmetic::F16Recovered, 14),
    (Arithmetic::F16Sparse, 6),
    (Arithmetic::Tf32, 6),
    (Arithmetic::Tf32Recovered, 14),
];
const CORES: [TensorCores; 2] = [TensorCores::Sm80, TensorCores::Sm90];

/// Small nets and meshlets of one kind.
fn small_meshlets(kind: Kind) -> Scene {
    let mut scene = Scene::new(kind);
    let sizes = [[1, 1], [1, 7], [7, 1], [3, 2], [2, 5], [6, 6]];
    for (k, size) in sizes.into_iter().enumerate() {
        scene.push([1 + k, 7 - k], size, &[([0, 0], size)]);
        scene.push([3, 3], [9, 9], &[([2, 1], size)]);
    }
    scene
}

fn device(tensor_cores: TensorCores) -> Device {
    Device::new(Schedule { tensor_cores, ..Schedule::default() }, 2)
}

/// Largest errors over all kinds of scenes: patches 30 px wide, and 1000 px.
#[derive(Clone, Copy, Default)]
struct Worst([Errors; 2]);

impl Worst {
    fn add(&mut self, kind: Kind, errors: Errors) {
        let worst = &mut self.0[usize::from(kind.width > 100.0)];
        *worst = worst.max(errors);
    }

    fn row(&self, kernel: &str, products: u32, cores: &str) -> String {
        let [narrow, wide] = self.0;
        let both = narrow.max(wide);
        let errors = [both.of_extent, narrow.px, wide.px, both.depth].map(|e| format!("{e:.1e}")).join(" | ");
        format!("| {kernel} | {products} | {} | {cores} | {errors} |\n", registers(kernel))
    }
}

#[test]
fn errors_are_those_of_the_precision() {
    let scenes = Kind::ALL.map(|kind| (kind, Scene::of_all_degrees(kind)));
    let mut f32_worst = Worst::default();
    let singles = scenes.each_ref().map(|(kind, scene)| {
        let single = scene.errors(&scene.evaluate(&mut Device::default(), F32));
        f32_worst.add(*kind, single);
        single
    });
    let mut rows = f32_worst.row(F32, 0, "any");
    for (arithmetic, products) in ARITHMETICS {
        let kernel = arithmetic.kernel([1, 2]).to_string();
        let recovered = matches!(arithmetic, Arithmetic::F16Recovered | Arithmetic::Tf32Recovered);
        for cores in CORES {
            let mut worst = Worst::default();
            for ((kind, scene), single) in scenes.iter().zip(singles) {
                let found = scene.errors(&scene.evaluate(&mut device(cores), &kernel));
                let good = !recovered || found.within(2.0, single);
                assert!(good, "{kernel} {cores:?} {kind:?}: {found:?}, f32 {single:?}");
                worst.add(*kind, found);
            }
            for (found, single) in worst.0.iter().zip(f32_worst.0) {
                assert!(!recovered || found.px <= 2.0 * single.px, "{kernel}: {found:?}");
            }
            rows.push_str(&worst.row(&kernel, products, &format!("{cores:?}")));
        }
    }
    agrees(TABLE, &table(&rows, &bounds(), &evaluate_normals::rows()));
}

/// How near errors come to their bounds.
fn bounds() -> String {
    let row = |arithmetic: Arithmetic| {
        let found = tightness(arithmetic);
        let cells = [0, 1, 2].map(|k| format!("{:.2} ({:.3})", found.largest[k], found.median[k]));
        format!("| {} | {} |\n", arithmetic.kernel([1, 2]), cells.join(" | "))
    };
    Arithmetic::ALL.map(row).concat()
}

/// On sm_80 / 86 / 89 / 90 / 120, as tests/kernel_resources has written them down.
fn registers(kernel: &str) -> String {
    let table = fs::read_to_string(root().join("bench/results/kernel-resources.md")).expect("the table of resources");
    let line = table.lines().find(|l| l.starts_with(&format!("| {kernel} |"))).unwrap_or_else(|| panic!("{kernel}"));
    let cells = line.split('|').skip(3).filter_map(|cell| cell.split_whitespace().next());
    cells.collect::<Vec<_>>().join(" / ")
}

fn table(rows: &str, bounds: &str, normals: &str) -> String {
    format!(
        "# What precisions of evaluation cost\n\nMade by `HALFPIXEL_UPDATE=1 cargo test --test kernels evaluate_mma` on the \
         emulator, with both models of tensor cores; nothing here was timed. Largest errors over 8 scenes of 6272 vertices: \
         nets of all degrees 1 to 7 in u and v, polynomial and with weights from 0.3 to 3, in perspective and orthographic \
         views, against f64, before snapping; depth relative in perspective. Products: mma.sync m16n8k8 a meshlet (tf32 \
         ones take twice the time of f16 ones), mma.sp m16n8k16 for f16_sparse. Registers: on sm_80 / 86 / 89 / 90 / 120.\n\n\
         | kernel | products | registers a thread | tensor cores | error / extent | px, 30 px wide | px, 1000 px wide | \
         depth |\n|---|---|---|---|---|---|---|---|\n{rows}\n\
         ## Errors over their a-priori bounds\n\nThe bounds of src/cuda/precision.rs, on 900 nets made to come near them: 1, \
         100 and 10,000 px wide, weights up to 1e-3 to 1e3, depth ratios up to 3, in perspective and orthographic views. \
         Largest part of the bound that an error reached (median of all patches); above 1 the test fails.\n\n\
         | kernel | place | depth | 1 / denominator |\n|---|---|---|---|\n{bounds}\n\
         ## Points, tangents and normals\n\nLargest errors over patches of all degrees 1 to 7 in u and v with weights from \
         0.5 to 2: of points over the patch's size, of tangents over their length, of normals in radians.\n\n\
         | kernel | point | tangent | normal |\n|---|---|---|---|\n{normals}"
    )
}

#[test]
fn small_meshlets_come_out_alike_in_any_order() {
    for kind in [Kind::ALL[3], Kind::ALL[5]] {
        let scene = small_meshlets(kind);
        for (arithmetic, _) in ARITHMETICS {
            let kernel = arithmetic.kernel([1, 2]).to_string();
            let vertices = under_all_schedules(|device| Bits(scene.evaluate(device, &kernel)));
            for (patch, found) in scene.errors_by_patch(&vertices.0).into_iter().enumerate() {
                let (hull, pixel) = scene.hull(patch);
                let allowed = arithmetic.bound(&hull).place * pixel + scene.snapping();
                assert!(found.px <= allowed, "{kernel} {kind:?}: {found:?}, {allowed}");
            }
        }
    }
}

/// Vertices that compare by their bits: gaps are NaN.
struct Bits(Vec<Vertex>);

impl PartialEq for Bits {
    fn eq(&self, other: &Self) -> bool {
        let bits = |v: &Vertex| (v.x, v.y, v.depth.to_bits(), v.weight.to_bits());
        self.0.iter().map(bits).eq(other.0.iter().map(bits))
    }
}

/// A net times a power of two is the same surface, far outside of f16's range too.
#[test]
fn scales_of_nets_do_not_matter() {
    let kind = Kind { rational: true, width: 1000.0, perspective: true };
    let mut scene = small_meshlets(kind);
    // Projective weights are 1 / w: as the net, so they.
    scene.view.projective = 0;
    for (arithmetic, _) in ARITHMETICS {
        let kernel = arithmetic.kernel([1, 2]).to_string();
        let expected = scene.evaluate(&mut Device::default(), &kernel);
        for factor in [2_f32.powi(-60), 2_f32.powi(60)] {
            let mut scaled = small_meshlets(kind);
            scaled.view.projective = 0;
            for p in &mut scaled.nets {
                [p.x, p.y, p.z, p.w] = [p.x, p.y, p.z, p.w].map(|c| c * factor);
            }
            let found = scaled.evaluate(&mut Device::default(), &kernel);
            assert!(Bits(found) == Bits(expected.clone()), "{kernel} times {factor}");
        }
    }
}
