//! From a surface's own parameters to those of its Bézier patches, one axis at a time.

use crate::geometry::exact::{arc_border, arc_count};

/// How one axis of the parameter plane stands to the surface's own parameter (an angle, a length, a knot parameter).
///
/// The plane is affine in the patches' Bézier parameters and agrees with the surface's parameter at patch borders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axis {
    /// They are the same.
    Same,
    /// Arcs as [`crate::geometry::exact::circle`] splits `range`; see [`crate::geometry::exact::arc_parameter`].
    Arcs { range: [f64; 2], count: usize },
    /// One hyperbola over `range`.
    Hyperbola { range: [f64; 2] },
}

impl Axis {
    /// The arcs that `range` is split into.
    pub fn arcs(range: [f64; 2]) -> Self {
        Self::Arcs { range, count: arc_count(range) }
    }

    /// The arc that holds `t` (the first or last one where it is outside).
    fn arc(range: [f64; 2], count: usize, t: f64) -> [f64; 2] {
        let k = ((t - range[0]) / (range[1] - range[0]) * count as f64).floor().clamp(0.0, count as f64 - 1.0) as usize;
        [arc_border(range, k), arc_border(range, k + 1)]
    }

    /// The plane's coordinate of the surface's parameter `t`.
    pub fn to_plane(&self, t: f64) -> f64 {
        match *self {
            Self::Same => t,
            Self::Arcs { range, count } => {
                let [a, b] = Self::arc(range, count, t);
                if t == a || t == b {
                    return t;
                }
                // arc_parameter, about the middle: no digits are lost next to it.
                let middle = 0.5 * (a + b);
                middle + 0.5 * (b - a) * (0.5 * (t - middle)).tan() / (0.25 * (b - a)).tan()
            }
            Self::Hyperbola { range: [a, b] } => {
                if t == a || t == b {
                    return t;
                }
                let middle = 0.5 * (a + b);
                middle + 0.5 * (b - a) * (0.5 * (t - middle)).tanh() / (0.25 * (b - a)).tanh()
            }
        }
    }

    /// The surface's parameter at the plane's coordinate `s`: the inverse of [`Axis::to_plane`].
    pub fn to_surface(&self, s: f64) -> f64 {
        match *self {
            Self::Same => s,
            Self::Arcs { range, count } => {
                let [a, b] = Self::arc(range, count, s);
                let middle = 0.5 * (a + b);
                middle + 2.0 * ((s - middle) / (0.5 * (b - a)) * (0.25 * (b - a)).tan()).atan()
            }
            Self::Hyperbola { range: [a, b] } => {
                let middle = 0.5 * (a + b);
                middle + 2.0 * ((s - middle) / (0.5 * (b - a)) * (0.25 * (b - a)).tanh()).atanh()
            }
        }
    }

    /// Where the map has a kink: the borders between arcs.
    pub fn kinks(&self) -> impl Iterator<Item = f64> + use<> {
        let (range, count) = match *self {
            Self::Arcs { range, count } => (range, count),
            Self::Same | Self::Hyperbola { .. } => ([0.0, 1.0], 1),
        };
        (1..count).map(move |k| arc_border(range, k))
    }
}
