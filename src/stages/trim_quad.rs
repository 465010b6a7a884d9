//! Part of trim: the parameters that a triangle gives to pixels and to blocks of them.

use super::evaluate::{SUBPIXELS, Vertex};
use glam::DVec3;

/// A triangle of a quad, in leaf parameters.
pub(super) struct Quad {
    /// The quad's rectangle.
    low: [f64; 2],
    high: [f64; 2],
    /// What the parameters of fragments may be off by.
    spread: [f64; 2],
    /// A corner, in pixels from the first pixel's centre.
    origin: [f64; 2],
    /// From the screen to the parameters: `[value at the origin, change a pixel in x, in y]` of u, v and 1, each times the
    /// weight of `Vertex`. Not a number for triangles without an area.
    map: [[f64; 3]; 3],
    /// From the rectangle's own unit square to the screen: pixels in x and in y, and 1, each over the weight, as
    /// `[value at the rectangle's low corner, change across it in u, in v]`.
    forward: [[f64; 3]; 3],
}

impl Quad {
    /// `corners`: parameters of the triangle's corners.
    pub fn new(
        low: [f64; 2],
        high: [f64; 2],
        spread: [f64; 2],
        corners: [[f64; 2]; 3],
        vertices: &[Vertex; 3],
    ) -> Self {
        let subpixels = f64::from(SUBPIXELS);
        let a = vertices[0];
        // Differences of sub-pixels are exact.
        let v = vertices.map(|v| [v.x - a.x, v.y - a.y].map(|c| f64::from(c) / subpixels));
        let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
        let side = |p: [f64; 2], q: [f64; 2]| [cross(p, q), p[1] - q[1], q[0] - p[0]];
        let sides = [side(v[1], v[2]), side(v[2], v[0]), side(v[0], v[1])];
        let area = sides.iter().map(|s| s[0]).sum::<f64>();
        let values = [0, 1, 2].map(|k| corners.map(|c| if k < 2 { c[k] } else { 1.0 }));
        let map = values.map(|values| {
            [0, 1, 2]
                .map(|c| (0..3).map(|n| sides[n][c] / area * f64::from(vertices[n].weight) * values[n]).sum::<f64>())
        });
        let origin = [a.x, a.y].map(|c| f64::from(c) / subpixels - 0.5);
        // The corners are 0 and 1 there: their sides and their area are exact.
        let c = corners.map(|p| [0, 1].map(|k| if p[k] > 0.5 * (low[k] + high[k]) { 1.0 } else { 0.0 }));
        let sides = [side(c[1], c[2]), side(c[2], c[0]), side(c[0], c[1])];
        let area = sides.iter().map(|s| s[0]).sum::<f64>();
        let forward = [0, 1, 2].map(|axis: usize| {
            let value = |n: usize| if axis < 2 { v[n][axis] + origin[axis] } else { 1.0 };
            [0, 1, 2]
                .map(|c| (0..3).map(|n| sides[n][c] / area / f64::from(vertices[n].weight) * value(n)).sum::<f64>())
        });
        Self { low, high, spread, origin, map, forward }
    }

    /// The screen as seen from the plane of the trims, in which the rectangle has these corners.
    pub fn to_screen(&self, [low, high]: [[f64; 2]; 2]) -> ToScreen {
        ToScreen { low, size: [high[0] - low[0], high[1] - low[1]], rows: self.forward.map(DVec3::from_array) }
    }

    /// The quad's rectangle of leaf parameters: low and high corner.
    pub fn rectangle(&self) -> [[f64; 2]; 2] {
        [self.low, self.high]
    }

    /// `[u, v]` at a pixel's centre; `None` where the denominator of the map is not positive.
    fn mapped(&self, x: i64, y: i64) -> Option<[f64; 2]> {
        let (x, y) = (x as f64 - self.origin[0], y as f64 - self.origin[1]);
        let [u, v, weight] = self.map.map(|f| f[0] + f[1] * x + f[2] * y);
        let inverse = 1.0 / weight;
        (weight > 0.0).then_some([u * inverse, v * inverse])
    }

    /// Parameters of the triangle's fragment at a pixel.
    pub fn at(&self, x: i64, y: i64) -> [f64; 2] {
        let p = self.mapped(x, y).unwrap_or([0, 1].map(|k| 0.5 * (self.low[k] + self.high[k])));
        [0, 1].map(|k| p[k].clamp(self.low[k], self.high[k]))
    }

    /// A box of parameters, as far as it is the quad's, with their errors.
    fn reached(&self, low: [f64; 2], high: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let inside = |k: usize, value: f64| value.clamp(self.low[k], self.high[k]);
        ([0, 1].map(|k| inside(k, low[k]) - self.spread[k]), [0, 1].map(|k| inside(k, high[k]) + self.spread[k]))
    }

    /// The same for a block of pixels.
    ///
    /// The map from the screen to the parameters is projective: where its denominator is positive it takes the block's
    /// hull into the hull of its corners' images.
    pub fn parameters(&self, [xs, ys]: [(i64, i64); 2]) -> ([f64; 2], [f64; 2]) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (x, y) in [(xs.0, ys.0), (xs.0, ys.1), (xs.1, ys.0), (xs.1, ys.1)] {
            let Some(p) = self.mapped(x, y) else { return self.reached(self.low, self.high) };
            low = [0, 1].map(|k| low[k].min(p[k]));
            high = [0, 1].map(|k| high[k].max(p[k]));
        }
        self.reached(low, high)
    }
}

/// A triangle's map from the plane of the trims to the screen: projective, pixels from the first pixel's centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct ToScreen {
    low: [f64; 2],
    size: [f64; 2],
    rows: [DVec3; 3],
}

impl ToScreen {
    /// A homogeneous point `(wu, wv, w)` as `(wx, wy, w)`; in front of the eye where that w is positive.
    pub fn image(&self, p: DVec3) -> DVec3 {
        let local = DVec3::new(p.z, (p.x - self.low[0] * p.z) / self.size[0], (p.y - self.low[1] * p.z) / self.size[1]);
        DVec3::from_array(self.rows.map(|row| row.dot(local)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vertex() -> impl Strategy<Value = Vertex> {
        (-20_000i32..20_000, -20_000i32..20_000, 0.1f32..1.0).prop_map(|(x, y, w)| Vertex { x, y, depth: w, weight: w })
    }

    proptest! {
        /// The map of a triangle of the unit quad, against perspective-correct barycentric weights.
        #[test]
        fn parameters_of_pixels(
            vertices in prop::array::uniform3(vertex()),
            pixel in prop::array::uniform2(-80i64..80),
            block in prop::array::uniform2(0i64..30),
        ) {
            let [a, b, c] = vertices.map(|v| [f64::from(v.x), f64::from(v.y)]);
            let area = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            prop_assume!(area(a, b, c).abs() > 1e5);
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
            let quad = Quad::new([0.0; 2], [1.0; 2], [0.0; 2], corners, &vertices);
            let exact = |[x, y]: [i64; 2]| {
                let p = [x, y].map(|c| (c * i64::from(SUBPIXELS)) as f64 + f64::from(SUBPIXELS / 2));
                let inside = [area(b, c, p), area(c, a, p), area(a, b, p)].map(|e| e / area(a, b, c));
                let weights: [f64; 3] = std::array::from_fn(|k| inside[k] * f64::from(vertices[k].weight));
                let sum: f64 = weights.iter().sum();
                let value = [0, 1].map(|k| (0..3).map(|n| weights[n] * corners[n][k]).sum::<f64>() / sum);
                (inside.iter().all(|&e| e >= 0.0), value)
            };
            let end = [0, 1].map(|k| pixel[k] + block[k]);
            let (low, high) = quad.parameters([(pixel[0], end[0]), (pixel[1], end[1])]);
            for x in pixel[0]..=end[0] {
                for y in pixel[1]..=end[1] {
                    let (covered, value) = exact([x, y]);
                    if covered {
                        let at = quad.at(x, y);
                        for k in 0..2 {
                            prop_assert!((at[k] - value[k]).abs() < 1e-9);
                            prop_assert!(low[k] - 1e-9 <= value[k] && value[k] <= high[k] + 1e-9);
                        }
                    }
                }
            }
        }
    }
}
