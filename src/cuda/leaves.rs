//! `abi::Leaf` of a leaf that the CPU culled and estimated.

use super::abi;
use super::precision::Arithmetic;
use crate::scene::Scene;
use crate::stages::cull::Leaf;
use crate::stages::estimate::Tessellation;
use crate::stages::lens::Lens;
use crate::stages::shade::{depth_tolerance, domain};
use crate::stages::stroke::Pen;
use crate::stages::trim_cut::{gaps, pixels_per_unit};
use crate::stages::{Options, Trim};

/// What the stages that draw a leaf know of it.
pub(crate) fn leaf(
    scene: &Scene,
    lens: &Lens,
    options: &Options,
    leaf: &Leaf,
    grid: &Tessellation,
    pen: &Pen,
    arithmetic: Arithmetic,
) -> abi::Leaf {
    let patch = &scene.patches[leaf.patch as usize];
    let tree = patch.trim.tree.filter(|_| options.trim != Trim::Off);
    // Pens of more than 2^31 sub-pixels cover every image.
    let subpixels = |radius: i64| i32::try_from(radius).unwrap_or(i32::MAX);
    abi::Leaf {
        corner: leaf.corner,
        extent: leaf.extent,
        plane_origin: patch.to_plane(leaf.corner),
        plane_size: [0, 1].map(|k| (patch.domain[k][1] - patch.domain[k][0]) * leaf.extent[k]),
        pixels_per_unit: pixels_per_unit(scene, lens, leaf),
        rounding: leaf.rounding,
        gaps: gaps(scene, lens, leaf),
        domain: domain(leaf),
        deviation: grid.deviation,
        depth_tolerance: depth_tolerance(lens, options, leaf),
        color: scene.color(leaf.instance, leaf.patch),
        pen_sides: pen.sides.map(subpixels),
        pen_radius: subpixels(pen.radius),
        pen_fold: subpixels(pen.fold),
        center: leaf.center,
        tree: tree.unwrap_or(abi::NO_TREE),
        rational: patch.rational.into(),
        arithmetic: arithmetic as u16,
    }
}
