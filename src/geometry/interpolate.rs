//! Polynomials through values at Chebyshev-Lobatto nodes, in Bernstein form.
//!
//! The nodes of degree n are every other node of degree 2 n, so that a higher degree reuses what was evaluated and the
//! rest shows the error; ends are interpolated. Trefethen, "Approximation Theory and Approximation Practice", chapter 2.

use super::bernstein::Coefficient;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// The degree of fits; half of it where that is enough.
pub const FIT_DEGREE: usize = 8;

/// The nodes of twice that degree, where fits are checked.
static NODES: LazyLock<[f64; 2 * FIT_DEGREE + 1]> =
    LazyLock::new(|| std::array::from_fn(|k| 0.5 - 0.5 * (PI * k as f64 / (2 * FIT_DEGREE) as f64).cos()));

/// Node `k` of `degree` on [0, 1]; the degree divides twice [`FIT_DEGREE`].
pub fn node(k: usize, degree: usize) -> f64 {
    NODES[k * (2 * FIT_DEGREE / degree)]
}

/// From values at the nodes to Bernstein coefficients, row by row: degree 4 and 8.
static TO_BERNSTEIN: LazyLock<[Vec<f64>; 2]> = LazyLock::new(|| [inverse(FIT_DEGREE / 2), inverse(FIT_DEGREE)]);

/// The Bernstein coefficients of the polynomial of degree [`FIT_DEGREE`], or half of it where `values` has that many,
/// with these values at the nodes.
///
/// # Panics
/// For any other number of values.
pub fn coefficients<T: Coefficient>(values: impl ExactSizeIterator<Item = T> + Clone) -> Vec<T> {
    let n = values.len();
    let matrix = match n - 1 {
        FIT_DEGREE => &TO_BERNSTEIN[1],
        half => {
            assert_eq!(half, FIT_DEGREE / 2, "number of values");
            &TO_BERNSTEIN[0]
        }
    };
    let sum = |row: &[f64]| row.iter().zip(values.clone()).fold(T::default(), |sum, (&m, p)| sum + p * m);
    matrix.chunks_exact(n).map(sum).collect()
}

/// The value at `t` of a polynomial in Bernstein form of at most [`FIT_DEGREE`], by de Casteljau.
pub fn value<T: Coefficient>(points: &[T], t: f64) -> T {
    let mut column = [T::default(); FIT_DEGREE + 1];
    let column = &mut column[..points.len()];
    column.copy_from_slice(points);
    for level in 1..points.len() {
        for k in 0..points.len() - level {
            column[k] = column[k] * (1.0 - t) + column[k + 1] * t;
        }
    }
    column[0]
}

/// Bernstein polynomials of `degree` at `t`.
fn bernstein(degree: usize, t: f64) -> Vec<f64> {
    let mut values = vec![1.0];
    for _ in 0..degree {
        let mut next = vec![0.0; values.len() + 1];
        for (k, value) in values.iter().enumerate() {
            next[k] += value * (1.0 - t);
            next[k + 1] += value * t;
        }
        values = next;
    }
    values
}

/// The inverse of the matrix of Bernstein values at the nodes, by Gauss-Jordan with pivoting.
fn inverse(degree: usize) -> Vec<f64> {
    let n = degree + 1;
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|k| {
            let mut row = bernstein(degree, node(k, degree));
            row.extend((0..n).map(|j| f64::from(u8::from(j == k))));
            row
        })
        .collect();
    for c in 0..n {
        let pivot = (c..n).max_by(|&a, &b| rows[a][c].abs().total_cmp(&rows[b][c].abs())).unwrap_or(c);
        rows.swap(c, pivot);
        let scale = 1.0 / rows[c][c];
        rows[c].iter_mut().for_each(|x| *x *= scale);
        let row = rows[c].clone();
        for other in (0..n).filter(|&k| k != c) {
            let factor = rows[other][c];
            rows[other].iter_mut().zip(&row).for_each(|(x, r)| *x -= factor * r);
        }
    }
    rows.into_iter().flat_map(|row| row[n..].to_vec()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_come_back_and_smooth_functions_nearly() {
        for degree in [4, 8] {
            let f = |t: f64| (0..=degree).map(|k| (k as f64 * 1.3).cos() * t.powi(k)).sum::<f64>();
            let nodes: Vec<f64> = (0..=degree as usize).map(|k| f(node(k, degree as usize))).collect();
            let points = coefficients(nodes.into_iter());
            for t in [0.0, 0.3, 0.77, 1.0] {
                assert!((value(&points, t) - f(t)).abs() < 1e-13, "degree {degree} at {t}");
            }
        }
        // The remainder of e^t: 8 nodes more than halve it many times over; e / (9! 2^17) is 6e-11.
        let nodes: Vec<f64> = (0..=8).map(|k| node(k, 8).exp()).collect();
        let points = coefficients(nodes.into_iter());
        let off =
            (0..=100).map(|k| f64::from(k) / 100.0).map(|t| (value(&points, t) - t.exp()).abs()).fold(0.0, f64::max);
        assert!(off < 1e-10 && off > 1e-13, "{off}");
    }
}
