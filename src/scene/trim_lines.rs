//! Trim curves as straight lines on the screen.

use super::trim_segment::{FEW, Segment};
use crate::geometry::{MAX_DEGREE, distance2_from_line};
use glam::{DVec2, DVec3};

/// Halvings of a curve on the way to straight lines.
const MAX_DEPTH: u32 = 60;

/// The part of the screen that lines are wanted in.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    pub low: DVec2,
    pub high: DVec2,
    /// What is seen in it has at least this weight (a point's third coordinate on the screen over that in the plane).
    pub weight: f64,
    /// Distance of a line from its piece of curve, at most.
    pub flat: f64,
}

impl Segment {
    /// Calls `line` with the ends of straight lines: all of the segment's image that the window shows lies within
    /// `window.flat` of one. `image` carries homogeneous points `(wu, wv, w)` to the screen's `(wx, wy, w)` and is linear.
    /// False where the curve can't be followed: nothing is known of it then.
    ///
    /// A curve with positive weights lies in the hull of its control points; so does its projective image.
    pub fn lines(
        &self,
        points: &[DVec3],
        window: &Window,
        image: impl Fn(DVec3) -> DVec3,
        line: &mut impl FnMut([DVec2; 2]),
    ) -> bool {
        let ends = self.ends.map(|[u, v]| DVec3::new(u, v, 1.0));
        let own = self.points(points);
        let own = if own.is_empty() { &ends[..] } else { own };
        let weight = own.iter().fold(f64::INFINITY, |least, p| least.min(p.z));
        let window = Window { weight: window.weight * weight, ..*window };
        match own.len() {
            2 => window.follow::<2>(&std::array::from_fn(|k| image(own[k])), 2, 0, line),
            3 => window.follow::<3>(&std::array::from_fn(|k| image(own[k])), 3, 0, line),
            4 => window.follow::<4>(&std::array::from_fn(|k| image(own[k])), 4, 0, line),
            n if n <= FEW => window.follow::<FEW>(&filled(own, image), n, 0, line),
            n => window.follow::<{ MAX_DEGREE + 1 }>(&filled(own, image), n, 0, line),
        }
    }
}

/// The images of some points in an array that has room for more.
fn filled<const N: usize>(points: &[DVec3], image: impl Fn(DVec3) -> DVec3) -> [DVec3; N] {
    std::array::from_fn(|k| points.get(k).map_or(DVec3::ZERO, |&p| image(p)))
}

impl Window {
    /// The first `count` of `points` are the control points of a piece.
    fn follow<const N: usize>(
        &self,
        points: &[DVec3; N],
        count: usize,
        depth: u32,
        line: &mut impl FnMut([DVec2; 2]),
    ) -> bool {
        let piece = &points[..count];
        let weights = piece.iter().fold((f64::INFINITY, 0.0f64), |(l, h), p| (l.min(p.z), h.max(p.z)));
        if weights.1 < self.weight {
            return true;
        }
        if weights.0 > 0.0 {
            let at = |p: DVec3| DVec2::new(p.x, p.y) / p.z;
            let screen: [DVec2; N] = std::array::from_fn(|k| if k < count { at(points[k]) } else { DVec2::ZERO });
            let screen = &screen[..count];
            let (low, high) = screen[1..].iter().fold((screen[0], screen[0]), |(l, h), &p| (l.min(p), h.max(p)));
            if !(low.cmple(self.high).all() && high.cmpge(self.low).all()) {
                return true;
            }
            let [a, b] = [screen[0], screen[count - 1]];
            if screen[1..count - 1].iter().all(|&p| distance2_from_line(p, [a, b]) <= self.flat * self.flat) {
                line([a, b]);
                return true;
            }
        }
        if depth == MAX_DEPTH {
            return false;
        }
        let (mut left, mut right) = (*points, *points);
        for (level, left) in left.iter_mut().enumerate().take(count).skip(1) {
            for k in 0..count - level {
                right[k] = (right[k] + right[k + 1]) * 0.5;
            }
            *left = right[0];
        }
        self.follow(&left, count, depth + 1, line) && self.follow(&right, count, depth + 1, line)
    }
}

#[cfg(test)]
mod tests {
    use super::super::trim_segment::split;
    use super::*;
    use crate::geometry::BezierCurve;
    use glam::DVec4;
    use proptest::prelude::*;

    proptest! {
        /// Points of a curve that the window shows lie as near to its lines as they should, whatever the degree and the view.
        #[test]
        fn lines_stay_near_the_curve(
            net in prop::collection::vec((-5.0f64..5.0, -5.0f64..5.0, 0.2f64..3.0), 2..12),
            tilt in prop::array::uniform2(-0.3f64..0.3),
            scale in 0.1f64..1e4,
        ) {
            let points = net.iter().map(|&(u, v, w)| DVec4::new(u * w, v * w, 0.0, w)).collect::<Vec<_>>();
            let Ok(curve) = BezierCurve::new("test", points) else { return Ok(()) };
            let image = |p: DVec3| DVec3::new(p.x * scale, (p.y + p.z) * scale, p.z + tilt[0] * p.x + tilt[1] * p.y);
            let window = Window { low: DVec2::splat(-6.0), high: DVec2::splat(10.0), weight: 0.05, flat: 1.0 / 16.0 };
            let (mut segments, mut list) = (Vec::new(), Vec::new());
            let plane = |t: f64| { let p = curve.jet(t).0; [p.x / p.w, p.y / p.w] };
            split(&curve, [plane(0.0), plane(1.0)], 0.0, &mut segments, &mut list);
            let mut lines = Vec::new();
            for segment in &segments {
                prop_assert!(segment.lines(&list, &window, image, &mut |line| lines.push(line)));
            }
            for k in 0..=200 {
                let [u, v] = plane(f64::from(k) / 200.0);
                let p = image(DVec3::new(u, v, 1.0));
                let at = DVec2::new(p.x, p.y) / p.z;
                if p.z >= window.weight && at.cmpge(window.low).all() && at.cmple(window.high).all() {
                    let least = lines.iter().map(|&line| distance2_from_line(at, line)).fold(f64::INFINITY, f64::min);
                    prop_assert!(least.sqrt() <= window.flat + 1e-9, "{} px away", least.sqrt());
                }
            }
        }
    }
}
