//! cull: nothing that can be seen is dropped, whatever the patch, the camera and the eye.

use super::Random;
use crate::cuda::selection::Selection;
use crate::geometry::BezierPatch;
use crate::import::builtin::builtin;
use crate::model::{Face, Model, Part, Solidity, Surface};
use crate::scene::{Camera, Scene, ViewSpec, prepare};
use crate::stages::cull::{Culler, Leaves};
use crate::stages::lens::Lens;
use crate::stages::{Cull, Options};
use glam::{DAffine3, DQuat, DVec3};
use std::f64::consts::TAU;

/// Points a side at which a patch is looked at.
const SIDE: usize = 24;

fn point(random: &mut Random, size: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| random.between(-size, size)))
}

/// One open patch about the origin, some flat, some with weights that differ a million times.
fn patch(random: &mut Random) -> Scene {
    let degree = [(); 2].map(|()| 1 + random.below(4) as usize);
    let spread = if random.below(4) == 0 { 1e3f64 } else { 3.0 };
    let flat = random.below(3) == 0;
    let points = (0..(degree[0] + 1) * (degree[1] + 1)).map(|_| {
        let w = spread.powf(random.between(-1.0, 1.0));
        let p = point(random, 1.0) * if flat { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
        (p * w).extend(w)
    });
    let surface = Surface::single(BezierPatch::new("random", degree, points.collect()).expect("a good patch"));
    let face = Face::new(0, "", surface);
    let part = Part { faces: vec![face], solidity: Solidity::Open, ..Part::default() };
    prepare(&Model::from_part("random", part), &|_, _| {}).expect("a scene")
}

/// A small picture from a random eye: outside, among the control points, or far away through a long lens.
fn camera(random: &mut Random, scene: &Scene) -> Camera {
    let spec = ViewSpec { size: [64, 48], orthographic: random.below(2) == 0, ..ViewSpec::default() };
    let (eye, zoom) = match random.below(3) {
        0 => (point(random, 4.0), 10f64.powf(random.between(-0.5, 1.5))),
        1 => (point(random, 1.0), random.between(0.3, 3.0)),
        _ => (point(random, 1.0).normalize() * 1e3, 10f64.powf(random.between(2.0, 4.0))),
    };
    let spec = ViewSpec { eye: Some(eye), target: Some(point(random, 1.0)), zoom, ..spec };
    spec.camera(&scene.bounds).expect("a camera")
}

/// What is left of one patch.
fn leaves(scene: &Scene, camera: &Camera, cull: Cull, patch: usize) -> Leaves {
    let (lens, options) = (Lens::new(camera), Options { cull, ..Options::default() });
    let mut out = Leaves::default();
    Culler::new(scene, &lens, &options, Selection::SINGLE)
        .patch(0, patch as u32, &mut out)
        .expect("not too many pieces");
    out
}

/// Parameters and world points of a grid on a patch.
fn samples(scene: &Scene, patch: usize) -> Vec<([f64; 2], DVec3, DVec3)> {
    let (patch, map) = (&scene.patches[patch], &scene.instances[0].transform);
    let at = |k: usize| k as f64 / (SIDE - 1) as f64;
    let sample = |k: usize| {
        let uv = [at(k / SIDE), at(k % SIDE)];
        let s = scene.net(patch).surface_point(uv[0], uv[1]);
        let [du, dv] = [s.du, s.dv].map(|d| map.transform_vector3(d));
        // A mirror turns the cross product of tangents against the outside.
        let normal = du.cross(dv) * map.matrix3.determinant().signum();
        (uv, map.transform_point3(s.position + patch.origin), normal)
    };
    (0..SIDE * SIDE).map(sample).collect()
}

/// The point is in the picture and safely behind the near plane: what crosses it may lose half a pixel.
fn is_in_picture(camera: &Camera, point: DVec3) -> bool {
    let c = camera.to_camera(point);
    let pixel = camera.project(c);
    let inside =
        pixel.cmpge(glam::DVec2::ZERO).all() && pixel.x <= camera.size[0].into() && pixel.y <= camera.size[1].into();
    c.z > camera.near + camera.pixel_size(camera.near) && inside
}

fn holds(leaves: &Leaves, [u, v]: [f64; 2]) -> bool {
    leaves.leaves.iter().any(|leaf| {
        let low = leaf.to_patch([0.0; 2]);
        let high = leaf.to_patch([1.0; 2]);
        (low[0]..=high[0]).contains(&u) && (low[1]..=high[1]).contains(&v)
    })
}

#[test]
fn no_visible_point_is_dropped() {
    let mut random = Random(8);
    let (mut seen, mut split) = (0, 0);
    for _ in 0..1500 {
        let scene = patch(&mut random);
        let camera = camera(&mut random, &scene);
        let left = leaves(&scene, &camera, Cull::Auto, 0);
        split += usize::from(left.leaves.len() > 1);
        for (uv, world, _) in samples(&scene, 0) {
            if is_in_picture(&camera, world) {
                seen += 1;
                assert!(holds(&left, uv), "{uv:?} of {:?} seen by {camera:?}", scene.points);
            }
        }
    }
    assert!(seen > 10_000 && split > 100, "{seen} points seen, {split} patches split");
}

#[test]
fn leaves_lie_where_the_later_stages_can_trust_them() {
    let mut random = Random(9);
    for _ in 0..1500 {
        let scene = patch(&mut random);
        let camera = camera(&mut random, &scene);
        for leaf in leaves(&scene, &camera, Cull::Auto, 0).leaves {
            assert!(leaf.low.z >= camera.near, "{leaf:?}");
            assert!(leaf.rounding <= crate::stages::cull::ROUNDING_BUDGET);
            let perspective = matches!(camera.projection, crate::scene::Projection::Perspective { .. });
            assert!(!perspective || leaf.high.z <= 3.0 * leaf.low.z, "{leaf:?}");
            let guard = f64::from(1 << 20);
            assert!(
                leaf.low.x > -guard && leaf.low.y > -guard && leaf.high.x < guard && leaf.high.y < guard,
                "{leaf:?}"
            );
        }
    }
}

/// A solid, turned, stretched and every other time mirrored.
fn solid(random: &mut Random, name: &str) -> Scene {
    let mut model = builtin(name).expect("a built-in");
    let mut scale = DVec3::from_array([(); 3].map(|()| random.between(0.3, 2.0)));
    if random.below(2) == 0 {
        scale.y = -scale.y;
    }
    let turn = DQuat::from_axis_angle(point(random, 1.0).normalize(), random.between(0.0, TAU));
    model.instances[0].transform = DAffine3::from_scale_rotation_translation(scale, turn, point(random, 3.0));
    prepare(&model, &|_, _| {}).expect("a scene")
}

#[test]
fn patches_of_a_solid_that_face_the_eye_are_kept() {
    let mut random = Random(10);
    let mut dropped = 0;
    for k in 0..300 {
        let scene = solid(&mut random, ["sphere", "torus", "drum"][k % 3]);
        let eye = scene.bounds.center() + point(&mut random, 1.0).normalize() * scene.bounds.radius() * 3.0;
        let spec = ViewSpec { size: [64, 64], orthographic: k % 2 == 0, eye: Some(eye), ..ViewSpec::default() };
        let camera = ViewSpec { fov: 60.0, ..spec }.camera(&scene.bounds).expect("a camera");
        for patch in scene.instances[0].patches.clone() {
            let left = leaves(&scene, &camera, Cull::Auto, patch).leaves;
            if !left.is_empty() {
                // Outward normals that point away from the eye: clockwise on the screen, but for a mirror.
                let turned = scene.instances[0].transform.matrix3.determinant().signum();
                assert!(left.iter().all(|leaf| f64::from(leaf.hidden) == turned));
                continue;
            }
            dropped += 1;
            for (uv, world, normal) in samples(&scene, patch) {
                let towards = if spec.orthographic { -camera.forward } else { eye - world };
                let away = normal.dot(towards) <= 1e-9 * normal.length() * towards.length();
                assert!(away || !is_in_picture(&camera, world), "patch {patch} at {uv:?}");
            }
        }
    }
    assert!(dropped > 100, "back patches are not culled: {dropped}");
}

/// From within a solid, or where the near plane cuts it open, its inside is all there is to see.
#[test]
fn the_inside_of_a_solid_is_kept() {
    let mut random = Random(11);
    for k in 0..60 {
        let scene = prepare(&builtin(["sphere", "drum"][k % 2]).expect("a built-in"), &|_, _| {}).expect("a scene");
        let eye = Some(point(&mut random, 0.5));
        let spec = ViewSpec { size: [64, 48], orthographic: k / 2 % 2 == 0, eye, ..ViewSpec::default() };
        let spec = ViewSpec { target: Some(point(&mut random, 5.0)), ..spec };
        let camera = spec.camera(&scene.bounds).expect("a camera");
        for patch in scene.instances[0].patches.clone() {
            let left = leaves(&scene, &camera, Cull::Auto, patch);
            assert!(left.leaves.iter().all(|leaf| leaf.hidden == 0));
            for (uv, world, _) in samples(&scene, patch) {
                assert!(!is_in_picture(&camera, world) || holds(&left, uv), "patch {patch} at {uv:?}");
            }
        }
    }
}
