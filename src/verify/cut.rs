//! The patches that show in the image, each cut into parts when a ray first comes near it.

use super::RESOLUTION;
use super::hierarchy::Hierarchy;
use super::piece::{Certificate, ImageBox, Piece, subdivide};
use super::ray::view_net;
use super::view::{Drawn, View};
use crate::geometry::BezierPatch;
use crate::scene::Scene;
use glam::{DVec2, DVec4};
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Boxes in the image of all patches that show there. Parts are kept until they are dropped, so a model of millions of
/// patches can be judged piece by piece of its picture.
#[derive(Debug, Default)]
pub(super) struct Cuts {
    shown: Vec<Shown>,
    hierarchy: Hierarchy,
    bytes: AtomicUsize,
}

#[derive(Debug)]
struct Shown {
    instance: u32,
    patch: u32,
    cut: OnceLock<Box<Cut>>,
}

/// A patch and its parts.
#[derive(Debug)]
pub(super) struct Cut {
    pub drawn: Drawn,
    leaves: Vec<Leaf>,
    hierarchy: Hierarchy,
}

/// A part of a patch that lies in one box of the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    /// `[[u0, u1], [v0, v1]]`
    pub domain: [[f64; 2]; 2],
    /// That no ray meets it twice, with the view point at its middle.
    pub certificate: Option<(Certificate, DVec4)>,
}

/// A part whose box is near a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<'a> {
    pub cut: &'a Cut,
    pub leaf: &'a Leaf,
    pub bounds: &'a ImageBox,
    /// Numbers of the patch and of its part, to put candidates of one depth in an order.
    pub number: [u32; 2],
}

/// Rays may start this many pixels outside the image.
const MARGIN: f64 = 1.0;

/// Parts of this many pixels are left to the single ray where they can't be certified (silhouettes run through them).
const LEAF_PIXELS: f64 = 4.0;

/// Parts a patch is cut into at most.
const MAX_LEAVES: usize = 4096;

impl Cuts {
    /// Patches with coordinates that are not finite in this view can't be hit.
    pub fn new(scene: &Scene, view: &View) -> Self {
        let pairs: Vec<(u32, u32)> = (0..)
            .zip(&scene.instances)
            .flat_map(|(instance, placed)| placed.patches.clone().map(move |patch| (instance, patch as u32)))
            .collect();
        let boxed = pairs.into_par_iter().filter_map(|(instance, patch)| {
            let bounds = patch_box(scene, view, instance, patch)?;
            Some((Shown { instance, patch, cut: OnceLock::new() }, bounds))
        });
        let (shown, boxes): (Vec<_>, Vec<_>) = boxed.unzip();
        Self { shown, hierarchy: Hierarchy::new(boxes.into_iter()), bytes: AtomicUsize::new(0) }
    }

    /// Calls `visit` for every part, of patches that are `wanted(instance, patch)`, whose box, `slack` wider, holds `p`.
    pub fn visit<'a>(
        &'a self,
        scene: &Scene,
        view: &View,
        (p, slack): (DVec2, f64),
        wanted: impl Fn(u32, u32) -> bool,
        mut visit: impl FnMut(Candidate<'a>),
    ) {
        self.hierarchy.visit(p, slack, |number, _| {
            let shown = &self.shown[number as usize];
            if !wanted(shown.instance, shown.patch) {
                return;
            }
            let cut = shown.cut.get_or_init(|| {
                let cut = Box::new(Cut::new(scene, view, shown.instance, shown.patch));
                self.bytes.fetch_add(cut.bytes(), Ordering::Relaxed);
                cut
            });
            cut.hierarchy.visit(p, slack, |leaf, bounds| {
                visit(Candidate { cut, leaf: &cut.leaves[leaf as usize], bounds, number: [number, leaf] });
            });
        });
    }

    /// Memory of the parts that were cut so far.
    pub fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Drops the parts; they are cut again where a ray needs them.
    pub fn forget(&mut self) {
        for shown in &mut self.shown {
            shown.cut.take();
        }
        self.bytes = AtomicUsize::new(0);
    }
}

impl Cut {
    fn new(scene: &Scene, view: &View, instance: u32, patch: u32) -> Self {
        let (drawn, net) = drawn_net(scene, view, instance, patch);
        let (boxes, leaves): (Vec<_>, Vec<_>) = leaves(view, net).into_iter().unzip();
        Self { drawn, leaves, hierarchy: Hierarchy::new(boxes.into_iter()) }
    }

    fn bytes(&self) -> usize {
        size_of::<Self>() + self.leaves.len() * size_of::<Leaf>() + self.hierarchy.bytes()
    }
}

/// A patch as it is drawn, and its control net in the view.
fn drawn_net(scene: &Scene, view: &View, instance: u32, patch: u32) -> (Drawn, BezierPatch) {
    let mut drawn = view.drawn(scene, instance, patch);
    let net = view_net(scene, &drawn);
    drawn.noise = view.noise(net.net());
    (drawn, net)
}

/// What rays may start from.
fn screen(view: &View) -> ImageBox {
    let reach = view.camera().center() + MARGIN;
    ImageBox { low: -reach, high: reach, depth: 0.0 }
}

fn is_finite(net: &BezierPatch) -> bool {
    net.points().iter().all(|q| q.is_finite())
}

/// The box of all parts of a patch that show in the image; `None` where there are none.
fn patch_box(scene: &Scene, view: &View, instance: u32, patch: u32) -> Option<ImageBox> {
    let (drawn, net) = drawn_net(scene, view, instance, patch);
    if !is_finite(&net) {
        return None;
    }
    let piece = Piece::whole(net);
    let mut bounds = piece.image_box(view)?;
    // The parts lie in the patch's hull but for rounding.
    let least = piece.net.points().iter().map(|&q| view.divisor_no_nearer(q)).fold(f64::INFINITY, f64::min);
    let rounding = drawn.noise / least;
    bounds.low -= rounding;
    bounds.high += rounding;
    let screen = screen(view);
    bounds.meets(&screen).then(|| bounds.clip(&screen))
}

/// Cuts one patch until its parts are certified or small, and drops what is outside the image or nearer than near.
fn leaves(view: &View, net: BezierPatch) -> Vec<(ImageBox, Leaf)> {
    let mut leaves = Vec::new();
    if !is_finite(&net) {
        return leaves;
    }
    let screen = screen(view);
    subdivide(Piece::whole(net), view, MAX_LEAVES, |piece, last| {
        let Some(image) = piece.image_box(view).filter(|image| image.meets(&screen)) else { return false };
        let bounds = image.clip(&screen);
        let net = piece.net.net();
        let half = bounds.size() * 0.5 + RESOLUTION;
        let certificate = Certificate::of(net, view, bounds.center(), half).map(|c| (c, net.jet(0.5, 0.5).point));
        if certificate.is_none() && !last && bounds.size().max_element() > LEAF_PIXELS {
            return true;
        }
        leaves.push((bounds, Leaf { domain: piece.domain, certificate }));
        false
    });
    leaves
}
