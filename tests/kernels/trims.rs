//! Trim trees on the device against those of the scene: points and boxes, among them those on curves and corners.

use crate::support::Random;
use glam::{DVec2, DVec4};
use halfpixel::cuda::trims::TrimsOnDevice;
use halfpixel::emulated::{Device, Schedule, Shape};
use halfpixel::geometry::BezierCurve;
use halfpixel::import;
use halfpixel::model::{Loop, TrimCurve};
use halfpixel::scene::{ParameterBox, Region, Trims, prepare};

/// Closed loops of rational curves of degrees 1 to 12, some with corners on a coarse raster.
fn loops(random: &mut Random) -> Vec<Loop> {
    let snap = random.below(3) == 0;
    let mut number = |low: f64, high: f64| low + (high - low) * (random.below(1 << 20) as f64 / f64::from(1 << 20));
    let mut point = || {
        let p = DVec2::new(number(-1.0, 1.0), number(-1.0, 1.0));
        let weight = number(0.2, 3.0);
        let p = if snap { (p * 4.0).round() * 0.25 } else { p };
        DVec4::new(p.x * weight, p.y * weight, 0.0, weight)
    };
    let corners: Vec<DVec4> = (0..7).map(|_| point()).collect();
    let piece = |k: usize, degree: usize, point: &mut dyn FnMut() -> DVec4| {
        let mut points = vec![corners[k]];
        points.extend((1..degree).map(|_| point()));
        points.push(corners[(k + 1) % corners.len()]);
        TrimCurve { curve: BezierCurve::new("test", points).expect("a good curve"), gap: 0.0, edge: None }
    };
    let curves = [1, 2, 3, 1, 4, 9, 12].into_iter().enumerate();
    vec![Loop { curves: curves.map(|(k, degree)| piece(k, degree, &mut point)).collect() }]
}

/// Compares all points, and the boxes about each two of them.
fn compare(trims: &Trims, tree: u32, points: &[[f64; 2]]) {
    let found = {
        let mut device = Device::new(Schedule::adversarial()[2], 2);
        let on_device = TrimsOnDevice::upload(&mut device, trims).expect("room");
        let flat = device.upload(&points.concat());
        let (inside, regions) = (device.zeroed::<u32>(points.len()), device.zeroed::<u32>(points.len() / 2));
        let count = points.len() as u32;
        let lists = on_device.pointers();
        let shape = Shape::of(points.len(), 64);
        let results = (inside.pointer(), regions.pointer());
        device
            .launch("selftest_trims", shape, &[&lists, &tree, &flat.pointer(), &count, &results.0, &results.1])
            .expect("no fault");
        (device.download(&inside).expect("a buffer"), device.download(&regions).expect("a buffer"))
    };
    let tree = trims.tree(tree);
    let inside: Vec<u32> = points.iter().map(|&p| tree.contains(p).into()).collect();
    let region = |pair: &[[f64; 2]]| match tree.classify(&ParameterBox::around([pair[0], pair[1]])) {
        Region::Inside => 0,
        Region::Outside => 1,
        Region::Boundary => 2,
    };
    let regions: Vec<u32> = points.chunks_exact(2).map(region).collect();
    assert!(inside.contains(&0) && inside.contains(&1));
    assert_eq!(found, (inside, regions));
}

#[test]
fn random_loops_cut_alike() {
    let mut random = Random(11);
    for _ in 0..20 {
        let loops = loops(&mut random);
        let mut trims = Trims::default();
        let tree = [trims.add(&loops), trims.add(&loops)][1];
        let mut points: Vec<[f64; 2]> = Vec::new();
        for _ in 0..400 {
            let p = [(); 2].map(|()| random.below(1 << 20) as f64 / f64::from(1 << 19) - 1.0);
            let small = 1.0 / (1 << random.below(20)) as f64;
            points.extend([p, [p[0] + small, p[1] - small * 0.7]]);
        }
        points.extend(loops.iter().flat_map(|l| &l.curves).flat_map(|c| {
            let jets = (0..=8).map(|k| c.curve.jet(f64::from(k) / 8.0).0);
            jets.map(|p| [p.x / p.w, p.y / p.w]).collect::<Vec<_>>()
        }));
        compare(&trims, tree, &points);
    }
}

#[test]
fn the_trees_of_a_drilled_plate_cut_alike() {
    let model = import::load("builtin:trimmed:drilled").expect("a model");
    let scene = prepare(&model, &|_, _| {}).expect("a scene");
    for patch in scene.patches.iter().filter(|p| p.trim.tree.is_some()).take(8) {
        let at = |i: u32, j: u32| patch.to_plane([f64::from(i) / 40.0, f64::from(j) / 41.0]);
        let points: Vec<_> = (0..=40).flat_map(|i| (0..=41).map(move |j| at(i, j))).collect();
        compare(&scene.trims, patch.trim.tree.expect("a tree"), &points);
    }
}
