//! Which patches the ray through an image point meets, where, and how far away.

use super::RESOLUTION;
use super::cut::{Candidate, Cut, Cuts, Leaf};
use super::ray::{Meeting, Ray};
use super::rim::Passing;
use super::trims::{Trims, WIDEST_REACH};
use super::view::{Drawn, ImagePoint, View};
use crate::scene::{Camera, Scene};
use glam::{DVec2, DVec4};

/// One intersection of a ray with a drawn patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Index into `Scene::patches`.
    pub patch: u32,
    /// In the patch's unit square.
    pub u: f64,
    pub v: f64,
    /// Camera depth in model units.
    pub depth: f64,
    /// Found by a Newton iteration with proof that its piece holds no other. Else the ray passes within `RESOLUTION`
    /// pixels of a piece that is smaller than that in the image (silhouettes, edge-on or collapsed patches), and `depth`
    /// is the piece's nearest; or it passes that near to a trim curve, outside of it.
    pub certified: bool,
}

/// What a ray sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    pub hit: Hit,
    /// The ray misses the face, but passes within the measured gap of its trim along this edge.
    pub shell: Option<Edge>,
}

/// The file's number of an edge; seams and poles have none.
pub(super) type Edge = Option<u32>;

/// Answers which surfaces a ray meets, in f64 and without any tessellation.
#[derive(Debug)]
pub struct Oracle<'a> {
    scene: &'a Scene,
    view: View,
    cuts: Cuts,
    trims: Trims<'a>,
    /// Pixels by which faces reach beyond their trims, at most.
    reach: f64,
}

/// Points looked at on the way from one parameter to another.
const WAY_POINTS: u32 = 8;

impl<'a> Oracle<'a> {
    /// Finds the patches that show in the image. What rays need of them, and of their faces' trims, is made when a ray
    /// first comes near.
    ///
    /// Patches with coordinates that are not finite in this view can't be hit.
    pub fn new(scene: &'a Scene, camera: &Camera) -> Self {
        let view = View::new(camera);
        let trims = Trims::new(scene);
        let reach = trims.widest_reach(camera);
        Self { scene, view, cuts: Cuts::new(scene, &view), trims, reach }
    }

    /// Memory of what was made for rays so far, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.cuts.bytes() + self.trims.bytes()
    }

    /// Drops what was made for rays; the next ones make what they need again, to the bit.
    pub(super) fn forget(&mut self) {
        self.cuts.forget();
        self.trims.forget();
    }

    /// Every intersection of the ray through image point (x, y) with every drawn face, nearest first; nothing nearer
    /// than the near distance, nothing outside a face's trims. Pixels, origin top left; (x, y) at most a pixel outside the
    /// image.
    ///
    /// A ray through the border of two patches meets both. Within one patch what can't be told apart at `RESOLUTION`
    /// is one hit.
    pub fn hits(&self, x: f64, y: f64) -> Vec<Hit> {
        self.sights(DVec2::new(x, y), 0.0, |_| f64::INFINITY).into_iter().map(|sight| sight.hit).collect()
    }

    /// What is seen no farther than `limit(depth of the nearest hit)`, nearest first, faces reaching beyond their trims.
    pub(super) fn front(&self, point: DVec2, limit: impl Fn(f64) -> f64) -> Vec<Sight> {
        self.sights(point, self.reach, limit)
    }

    fn sights(&self, point: DVec2, reach: f64, limit: impl Fn(f64) -> f64) -> Vec<Sight> {
        let pixel = point - self.view.camera().center();
        let mut candidates = Vec::new();
        let all = |_, _| true;
        self.cuts.visit(self.scene, &self.view, (pixel, reach + RESOLUTION), all, |part| candidates.push(part));
        candidates.sort_unstable_by(|a, b| a.bounds.depth.total_cmp(&b.bounds.depth).then(a.number.cmp(&b.number)));
        let mut hits = Vec::new();
        let mut beyond: Vec<Sight> = Vec::new();
        let mut rims = Vec::new();
        let mut found = Vec::new();
        let mut nearest = f64::INFINITY;
        let mut farthest = f64::INFINITY;
        for Candidate { cut: Cut { drawn, .. }, leaf, bounds, .. } in candidates {
            if bounds.depth > farthest {
                break;
            }
            if bounds.contains(pixel, RESOLUTION) {
                self.meet(drawn, leaf, pixel, &mut found);
            }
            for meeting in found.drain(..) {
                if meeting.depth < nearest {
                    nearest = meeting.depth;
                    farthest = limit(nearest);
                }
                add(&mut hits, drawn, meeting);
            }
            let face = (drawn.instance, self.scene.patches[drawn.patch as usize].face);
            if self.trims.are_on(face.1) && !rims.contains(&face) {
                rims.push(face);
                self.pass(point, reach, face, &mut beyond);
            }
        }
        let hits = hits.into_iter().map(|(drawn, meeting)| Sight { hit: hit(drawn, &meeting), shell: None });
        self.merged(hits.collect(), beyond, limit)
    }

    /// Hits and what passes near trims, without what is a hit already, up to the limit.
    fn merged(&self, mut sights: Vec<Sight>, beyond: Vec<Sight>, limit: impl Fn(f64) -> f64) -> Vec<Sight> {
        for new in beyond {
            let face = |s: &Sight| (s.hit.instance, self.scene.patches[s.hit.patch as usize].face);
            let near = self.view.camera().pixel_size(new.hit.depth);
            let same = |old: &Sight| {
                old.shell == new.shell && face(old) == face(&new) && (old.hit.depth - new.hit.depth).abs() <= near
            };
            if !sights.iter().any(same) {
                sights.push(new);
            }
        }
        let depths = |exact: bool| sights.iter().filter(move |s| s.shell.is_none() == exact).map(|s| s.hit.depth);
        let exact = depths(true).fold(f64::INFINITY, f64::min);
        let nearest = if exact.is_finite() { exact } else { depths(false).fold(f64::INFINITY, f64::min) };
        let farthest = limit(nearest);
        sights.retain(|s| s.hit.depth <= farthest);
        sights.sort_by(|a, b| a.hit.depth.total_cmp(&b.hit.depth));
        sights
    }

    /// Adds where the ray passes near the trims of a face.
    fn pass(&self, point: DVec2, widest: f64, (instance, face): (u32, u32), beyond: &mut Vec<Sight>) {
        let camera = self.view.camera();
        let Some(ray) = self.trims.ray(camera, instance, point) else { return };
        let reach = |gap: f64, pixel: f64| gap.min(widest * pixel) + RESOLUTION * pixel;
        self.trims.passings(camera, &ray, face, widest + RESOLUTION, reach, |passing| {
            let Passing { patch, parameter: [u, v], depth, distance, edge } = passing;
            let touching = distance <= RESOLUTION * camera.pixel_size(depth);
            // Beyond an edge that no other face has, the model goes on nowhere.
            let shared = edge.is_none_or(|edge| self.trims.faces_at(instance, edge).len() > 1);
            if touching || shared {
                let hit = Hit { instance, patch, u, v, depth, certified: false };
                beyond.push(Sight { hit, shell: (!touching).then_some(edge) });
            }
        });
    }

    /// A face has the edge along which another reaches beyond its trim; or it is that face, and the edge is a seam.
    pub(super) fn has_edge(&self, sight: &Sight, edge: Edge, (instance, face): (u32, u32)) -> bool {
        sight.hit.instance == instance
            && match edge {
                Some(edge) => self.trims.faces_at(instance, edge).contains(&[edge, face]),
                None => self.scene.patches[sight.hit.patch as usize].face == face,
            }
    }

    /// A point of a patch is a point of its face, or lies outside its trims by no more than the gap and `slack` pixels,
    /// and the straight way to the trim stays that near in the image.
    pub(super) fn belongs(&self, instance: u32, patch: u32, uv: [f64; 2], slack: f64) -> bool {
        if self.trims.contain(patch, uv) {
            return true;
        }
        let Some(place) = self.project(instance, patch, uv) else { return false };
        let camera = self.view.camera();
        let Some(ray) = self.trims.ray(camera, instance, place.pixel) else { return false };
        let face = self.scene.patches[patch as usize].face;
        let from = self.trims.plane_point(patch, uv);
        let widest = WIDEST_REACH + slack.max(RESOLUTION);
        let reach = |gap: f64, pixel: f64| gap.min(WIDEST_REACH * pixel) + slack.max(RESOLUTION) * pixel;
        let mut near = false;
        self.trims.passings(camera, &ray, face, widest, reach, |passing| {
            let to = self.trims.plane_point(passing.patch, passing.parameter);
            near |= (1..WAY_POINTS).all(|k| {
                let way = self.trims.locate(face, from.lerp(to, f64::from(k) / f64::from(WAY_POINTS)));
                let point = way.and_then(|(patch, uv)| self.project(instance, patch, uv));
                point.is_some_and(|p| p.pixel.distance(place.pixel) <= 2.0 * widest)
            });
        });
        near
    }

    /// All meetings of the ray through the image point with one patch, hidden or not.
    pub(super) fn meetings(&self, point: DVec2, instance: u32, patch: u32) -> Vec<Hit> {
        let pixel = point - self.view.camera().center();
        let mut found = Vec::new();
        let wanted = |i, p| (i, p) == (instance, patch);
        self.cuts.visit(self.scene, &self.view, (pixel, RESOLUTION), wanted, |Candidate { cut, leaf, .. }| {
            let mut meetings = Vec::new();
            self.meet(&cut.drawn, leaf, pixel, &mut meetings);
            found.extend(meetings.iter().map(|m| hit(&cut.drawn, m)));
        });
        found
    }

    /// Where a point of a patch lies in the image, and the sign of the map from (u, v) to the image there: which side
    /// of the surface faces the eye.
    pub(super) fn facing(&self, instance: u32, patch: u32, [u, v]: [f64; 2]) -> (DVec2, f64) {
        let jet = self.view.drawn(self.scene, instance, patch).jet(self.scene, u, v);
        let pixel = self.view.pixel(jet.point);
        let along = |d: DVec4| d.truncate().truncate() - pixel * self.view.divisor(d);
        // Both tangents are short of the same positive factor 1/D.
        (pixel + self.view.camera().center(), along(jet.du).perp_dot(along(jet.dv)).signum())
    }

    /// Where a surface point lies in the image; `None` without such a patch, or where it has no pixel.
    pub(super) fn project(&self, instance: u32, patch: u32, [u, v]: [f64; 2]) -> Option<ImagePoint> {
        if !self.scene.instances.get(instance as usize)?.patches.contains(&(patch as usize)) {
            return None;
        }
        let q = self.view.drawn(self.scene, instance, patch).jet(self.scene, u, v).point;
        let point = self.view.image_point(q);
        (self.view.divisor(q) > 0.0 && point.pixel.is_finite() && point.depth.is_finite()).then_some(point)
    }

    pub(super) fn scene(&self) -> &'a Scene {
        self.scene
    }

    pub(super) fn camera(&self) -> &Camera {
        self.view.camera()
    }

    fn meet(&self, drawn: &Drawn, leaf: &Leaf, pixel: DVec2, found: &mut Vec<Meeting>) {
        let start = found.len();
        Ray { scene: self.scene, view: &self.view, drawn, pixel }.meet(leaf, found);
        let kept = (start..found.len()).filter(|&k| self.trims.contain(drawn.patch, found[k].parameter));
        let kept: Vec<Meeting> = kept.map(|k| found[k]).collect();
        found.truncate(start);
        found.extend(kept);
    }
}

fn hit(&Drawn { instance, patch, .. }: &Drawn, meeting: &Meeting) -> Hit {
    let [u, v] = meeting.parameter;
    Hit { instance, patch, u, v, depth: meeting.depth, certified: meeting.certified }
}

/// Adds a meeting unless it is one that the patch's neighbouring piece has found already.
fn add<'a>(hits: &mut Vec<(&'a Drawn, Meeting)>, drawn: &'a Drawn, new: Meeting) {
    let same = |(of, old): &(&Drawn, Meeting)| {
        // About a tangential hit some small pieces are excluded and others not: these belong together.
        let reach = if old.certified && new.certified { 1.01 } else { 4.0 };
        (of.instance, of.patch) == (drawn.instance, drawn.patch)
            && (0..2).all(|axis| {
                (old.parameter[axis] - new.parameter[axis]).abs() <= reach * (old.extent[axis] + new.extent[axis])
            })
    };
    let Some((_, old)) = hits.iter_mut().find(|old| same(old)) else {
        return hits.push((drawn, new));
    };
    if new.certified && !old.certified {
        *old = new;
    } else if !new.certified && !old.certified {
        *old = old.joined(&new);
    }
}
