//! What one pixel is judged by (DESIGN section 6).

use super::hits::{Hit, Oracle, Sight};
use super::view::ImagePoint;
use crate::scene::Projection;
use crate::stages::Pixel;
use glam::DVec2;
use std::cell::OnceCell;
use std::f64::consts::SQRT_2;

/// The contract's half pixel.
pub(super) const HALF_PIXEL: f64 = 0.5;

/// The frame stores depth in f32 (relative to camera depth in perspective, to the depth range in orthographic
/// projection). A fragment's takes three to five roundings at its vertices and seven in interpolation (area, its inverse,
/// weight, two products, two sums), and where two compete both err: 20 to 24 half-ulps at worst. Sixteen are allowed.
const DEPTH_ROUNDING: f64 = 16.0 * f32::EPSILON as f64 / 2.0;

/// Refinement ends within 1/512 px of a pixel's centre in x and in y, and trims are tested where it ends. So a shown point
/// may lie outside its face's trims by that and the rounding of f32, on the diagonal; it stands for the point of the trim
/// beside it, which is the face's.
const REFINED: f64 = 1.0 / 128.0;

/// Sub-samples a side; they span the closed square, so the middle one is the centre.
const SIDE: usize = 5;

/// Rays a side through a pixel in which the shown face was not found, its border included.
const DENSE_SIDE: usize = 17;

/// Judges pixels.
pub(super) struct Check<'a, 's> {
    pub oracle: &'a Oracle<'s>,
    /// Pixel sizes.
    pub depth_tolerance: f64,
}

/// What was found about one drawn or background pixel. Errors are L-infinity, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Verdict {
    pub grid_error: Option<f64>,
    pub parametric_error: Option<f64>,
    pub refined_error: Option<f64>,
    pub crack: bool,
    pub covering_failure: bool,
    pub depth_failure: bool,
}

/// The rays of one pixel, shot when first asked for.
struct Samples<'a, 's> {
    check: &'a Check<'a, 's>,
    center: DVec2,
    rays: [OnceCell<Vec<Sight>>; SIDE * SIDE],
}

/// Parameters nearer than this are on one sheet.
const NEXT_TO: f64 = 1e-4;
/// Points looked at on the way from one parameter to another.
const WAY_POINTS: u32 = 16;

/// A face of an instance.
type FaceKey = (u32, u32);

impl Verdict {
    pub fn violation(&self) -> bool {
        self.worst_error().is_some_and(|e| e > HALF_PIXEL)
    }

    /// The larger of the two errors that the contract bounds.
    pub fn worst_error(&self) -> Option<f64> {
        match (self.grid_error, self.parametric_error) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        }
    }
}

impl Check<'_, '_> {
    /// Judges pixel (x, y), which shows `pixel`, or background.
    pub fn judge(&self, x: u32, y: u32, pixel: Option<&Pixel>) -> Verdict {
        let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let samples = Samples { check: self, center, rays: Default::default() };
        match pixel {
            None => Verdict { crack: samples.all_hit(), ..Verdict::default() },
            Some(pixel) => self.judge_drawn(pixel, &samples),
        }
    }

    fn judge_drawn(&self, pixel: &Pixel, samples: &Samples) -> Verdict {
        let project = |uv| self.oracle.project(pixel.instance, pixel.patch, uv);
        let stored = project(pixel.stored);
        let interpolated = if pixel.interpolated == pixel.stored { stored } else { project(pixel.interpolated) };
        let error = |point: Option<ImagePoint>| {
            // No such point: as wrong as can be.
            point.map_or(f64::MAX, |p| (p.pixel - samples.center).abs().max_element())
        };
        let parametric = error(stored);
        let depth = stored.map_or(f64::INFINITY, |p| p.depth);
        let visible = self.is_in_trims(pixel) && self.face_is_visible(pixel, samples, [stored, interpolated]);
        let face = self.face_of(pixel);
        Verdict {
            grid_error: (!pixel.filled).then(|| error(interpolated)),
            parametric_error: Some(parametric),
            refined_error: self.meets(pixel, samples).then_some(parametric),
            crack: samples.all_hide(depth, face),
            covering_failure: !visible,
            depth_failure: visible && samples.all_hide(self.farthest_depth(pixel, depth), face),
        }
    }

    /// Depth of the shown point: the surface's at the stored parameter, or what the buffer says where that is farther.
    /// Strokes are pushed back in the buffer on purpose (DESIGN section 4), so for filled pixels it does not count.
    fn farthest_depth(&self, pixel: &Pixel, depth: f64) -> f64 {
        if pixel.filled { depth } else { depth.max(self.oracle.camera().camera_depth(f64::from(pixel.depth))) }
    }

    /// The centre ray meets the shown patch on the sheet that is shown: the straight way from the stored parameter to
    /// the meeting stays within a pixel of the centre and crosses no silhouette. (A ray may meet the same patch again
    /// elsewhere; refinement must not go there.)
    fn meets(&self, pixel: &Pixel, samples: &Samples) -> bool {
        let shown = |h: &&Hit| h.instance == pixel.instance && h.patch == pixel.patch;
        let same_sheet = |h: &Hit| self.is_same_sheet(pixel, samples.center, [h.u, h.v]);
        // The visible hits are known already.
        samples.ray(0).iter().filter(|s| s.shell.is_none()).map(|s| &s.hit).filter(shown).any(same_sheet)
            || self.oracle.meetings(samples.center, pixel.instance, pixel.patch).iter().any(same_sheet)
    }

    fn is_same_sheet(&self, pixel: &Pixel, center: DVec2, hit: [f64; 2]) -> bool {
        let way = DVec2::from_array(hit) - DVec2::from_array(pixel.stored);
        if way.abs().max_element() < NEXT_TO {
            return true;
        }
        let facing = |uv| self.oracle.facing(pixel.instance, pixel.patch, uv);
        let side = facing(pixel.stored).1;
        (0..=WAY_POINTS).all(|k| {
            let uv = DVec2::from_array(pixel.stored) + way * (f64::from(k) / f64::from(WAY_POINTS));
            let (place, here) = facing(uv.to_array());
            (place - center).abs().max_element() <= 1.0 && (here == side || k == WAY_POINTS)
        })
    }

    /// Some point of the shown face in the pixel's closed square is visible to within delta: at the centre, at the
    /// sub-samples, at what the frame says it shows, or at any of many more rays.
    fn face_is_visible(&self, pixel: &Pixel, samples: &Samples, shown: [Option<ImagePoint>; 2]) -> bool {
        let Some(face) = self.face_of(pixel) else { return false };
        let uv = [pixel.stored, pixel.interpolated];
        let visible = |(point, uv): (Option<ImagePoint>, [f64; 2])| {
            point.is_some_and(|p| {
                self.oracle.belongs(pixel.instance, pixel.patch, uv, REFINED)
                    && self.is_visible(&p, samples.center, face)
            })
        };
        (0..SIDE * SIDE).any(|i| self.shows(samples.ray(i), face))
            || shown.into_iter().zip(uv).any(visible)
            || grid(DENSE_SIDE).any(|offset| self.shows(&self.front(samples.center + offset), face))
    }

    /// The stored point is one of its face, or beyond its trims by no more than the gap and half a pixel.
    fn is_in_trims(&self, pixel: &Pixel) -> bool {
        let slack = HALF_PIXEL * SQRT_2;
        self.face_of(pixel).is_some() && self.oracle.belongs(pixel.instance, pixel.patch, pixel.stored, slack)
    }

    /// The face that a pixel shows, if there is such a patch.
    fn face_of(&self, pixel: &Pixel) -> Option<FaceKey> {
        let patch = self.oracle.scene().patches.get(pixel.patch as usize)?;
        Some((pixel.instance, patch.face))
    }

    /// One of the visible hits of a ray lies on the face.
    fn shows(&self, front: &[Sight], face: FaceKey) -> bool {
        let scene = self.oracle.scene();
        front.iter().any(|s| (s.hit.instance, scene.patches[s.hit.patch as usize].face) == face)
    }

    /// A given surface point lies in the square and nothing hides it.
    fn is_visible(&self, point: &ImagePoint, center: DVec2, face: FaceKey) -> bool {
        (point.pixel - center).abs().max_element() <= HALF_PIXEL
            && point.depth >= self.oracle.camera().near
            && !self.hides(&self.front(point.pixel), point.depth, Some(face))
    }

    /// What is visible along a ray: no farther than delta beyond the nearest hit.
    fn front(&self, point: DVec2) -> Vec<Sight> {
        self.oracle.front(point, |nearest| nearest + self.delta(nearest))
    }

    /// A hit hides a point at this depth, or a face's reach does along an edge that the point's face has not.
    fn hides(&self, front: &[Sight], depth: f64, face: Option<FaceKey>) -> bool {
        let nearer = |s: &&Sight| !depth.is_finite() || s.hit.depth < depth - self.delta(depth);
        front.iter().take_while(nearer).any(|sight| match (sight.shell, face) {
            (Some(edge), Some(face)) => !self.oracle.has_edge(sight, edge, face),
            _ => true,
        })
    }

    /// What depths may differ by at camera depth z: the depth tolerance and the rounding of stored depths.
    fn delta(&self, z: f64) -> f64 {
        let camera = self.oracle.camera();
        let range = match camera.projection {
            Projection::Perspective { .. } => z,
            Projection::Orthographic { .. } => camera.extent,
        };
        self.depth_tolerance * camera.pixel_size(z) + DEPTH_ROUNDING * range
    }
}

impl Samples<'_, '_> {
    /// The visible hits at one sub-sample; number 0 is the centre.
    fn ray(&self, index: usize) -> &[Sight] {
        self.rays[index].get_or_init(|| {
            // The centre changes places with the first of the grid.
            let middle = SIDE * SIDE / 2;
            let at = if index == 0 {
                middle
            } else if index == middle {
                0
            } else {
                index
            };
            self.check.front(self.center + grid(SIDE).nth(at).unwrap_or_default())
        })
    }

    fn all_hit(&self) -> bool {
        (0..SIDE * SIDE).all(|i| !self.ray(i).is_empty())
    }

    fn all_hide(&self, depth: f64, face: Option<FaceKey>) -> bool {
        (0..SIDE * SIDE).all(|i| self.check.hides(self.ray(i), depth, face))
    }
}

/// Offsets of `side` x `side` points that span the closed pixel about its centre.
fn grid(side: usize) -> impl Iterator<Item = DVec2> {
    let at = move |i: usize| i as f64 / (side - 1) as f64 - 0.5;
    (0..side * side).map(move |i| DVec2::new(at(i % side), at(i / side)))
}
