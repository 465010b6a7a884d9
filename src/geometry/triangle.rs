//! Bézier triangles as tensor-product patches with one edge drawn together to a point.

use glam::DVec4;

/// The control net (degree x degree, row major) of the tensor-product patch that is the Bézier triangle `points`.
///
/// `points` come in rows: from the corner A to the corner B first, the last one is the corner C. With the barycentric
/// coordinates `1 - u`, `u (1 - v)`, `u v` of A, B and C the triangle is
/// `sum_m B_m^d(u) sum_k B_k^m(v) P[d - m, m - k, k]`: row m of the net is a curve of degree m in v, raised to degree
/// d. The edge u = 0 is the point A; the other three edges are the triangle's own, with the same numbers.
pub fn triangle_to_tensor(degree: usize, points: &[DVec4]) -> Vec<DVec4> {
    assert_eq!(points.len(), (degree + 1) * (degree + 2) / 2, "control points of a triangle");
    // Row k of the triangle holds degree + 1 - k points and starts after those before it.
    let index = |j: usize, k: usize| k * (2 * degree + 3 - k) / 2 + j;
    let mut net = Vec::with_capacity((degree + 1) * (degree + 1));
    for m in 0..=degree {
        let mut row: Vec<DVec4> = (0..=m).map(|k| points[index(m - k, k)]).collect();
        while row.len() <= degree {
            raise(&mut row);
        }
        net.extend(row);
    }
    net
}

/// Raises the degree of a Bézier curve by one (Farin, Curves and Surfaces for CAGD, section 6.1). End points keep
/// their bits, and so do points that are all the same.
fn raise(curve: &mut Vec<DVec4>) {
    let count = curve.len();
    let Some(&last) = curve.last() else { return };
    for i in (1..count).rev() {
        let t = i as f64 / count as f64;
        let step = (curve[i - 1] - curve[i]) * t;
        curve[i] += step;
    }
    curve.push(last);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::BezierPatch;
    use glam::DVec3;

    /// De Casteljau on the triangle itself, at barycentric coordinates `b` of A, B and C.
    fn triangle_point(degree: usize, points: &[DVec4], b: [f64; 3]) -> DVec4 {
        let mut level: Vec<Vec<DVec4>> = Vec::new();
        let mut rest = points;
        for k in 0..=degree {
            let (row, after) = rest.split_at(degree + 1 - k);
            level.push(row.to_vec());
            rest = after;
        }
        for d in (0..degree).rev() {
            let blend = |k: usize, j: usize| level[k][j] * b[0] + level[k][j + 1] * b[1] + level[k + 1][j] * b[2];
            level = (0..=d).map(|k| (0..=d - k).map(|j| blend(k, j)).collect()).collect();
        }
        level[0][0]
    }

    fn scattered(count: usize) -> Vec<DVec4> {
        let wave = |i: usize, f: f64| (i as f64 * f).sin() * 3.0;
        (0..count)
            .map(|i| DVec3::new(wave(i, 1.7), wave(i, 2.3), wave(i, 4.1)).extend(1.0 + 0.1 * (i % 7) as f64))
            .collect()
    }

    #[test]
    fn tensor_patch_is_the_triangle() {
        for degree in 1..=9 {
            let points = scattered((degree + 1) * (degree + 2) / 2);
            let patch = BezierPatch::new("test", [degree; 2], triangle_to_tensor(degree, &points)).unwrap();
            for (i, j) in (0..=8).flat_map(|i| (0..=8).map(move |j| (i, j))) {
                let (u, v) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                let exact = triangle_point(degree, &points, [1.0 - u, u * (1.0 - v), u * v]);
                let found = patch.net().jet(u, v).point;
                assert!((found - exact).abs().max_element() < 1e-13, "degree {degree} at {u} {v}: {found} {exact}");
            }
        }
    }

    #[test]
    fn edges_keep_their_control_points() {
        let points = scattered(15);
        let net = triangle_to_tensor(4, &points);
        let column = |j: usize| net.iter().skip(j).step_by(5).copied().collect::<Vec<_>>();
        assert!(net[..5].iter().all(|p| *p == points[0]), "u = 0 is the corner A");
        assert_eq!(column(0), points[..5], "v = 0 is the edge from A to B");
        assert_eq!(column(4), [0, 5, 9, 12, 14].map(|i| points[i]), "v = 1 is the edge from A to C");
        assert_eq!(net[20..], [4, 8, 11, 13, 14].map(|i| points[i]), "u = 1 is the edge from B to C");
    }
}
