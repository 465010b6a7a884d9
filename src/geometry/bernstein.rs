//! Tensor-product polynomials in Bernstein form, and enclosures of a rational patch's second derivatives.
//!
//! Coefficients are kept *scaled*, that is multiplied by `C(m, i) C(n, j)` (Sánchez-Reyes, "Algebraic manipulation in
//! the Bernstein form made simple via convolutions", 2003): products are then plain convolutions and degree elevation
//! is a product with the constant 1.

use super::{BezierPatch, Net};
use glam::{DVec3, DVec4};
use std::ops::{Add, Mul, Sub};

/// What a polynomial can have as coefficients: numbers and vectors.
pub trait Coefficient: Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Default + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Coefficient for T {}

/// A polynomial over [0, 1]² of degree `[m, n]` in scaled Bernstein form, u outermost.
#[derive(Clone, Debug, PartialEq)]
pub struct Bernstein<T> {
    degree: [usize; 2],
    scaled: Vec<T>,
}

/// `C(degree, 0..=degree)`; exact while below 2^53, good to a few units in the last place beyond.
pub fn binomials(degree: usize) -> Vec<f64> {
    let mut row = Vec::with_capacity(degree + 1);
    let mut value = 1.0;
    for k in 0..=degree {
        row.push(value);
        value = value * (degree - k) as f64 / (k + 1) as f64;
    }
    row
}

impl<T: Coefficient> Bernstein<T> {
    /// From ordinary Bernstein coefficients, `(m + 1) (n + 1)` of them.
    pub fn new(degree: [usize; 2], coefficients: impl IntoIterator<Item = T>) -> Self {
        let [m, n] = degree;
        let [row, column] = [binomials(m), binomials(n)];
        let scales = row.iter().flat_map(|r| column.iter().map(move |c| r * c));
        let scaled: Vec<T> = coefficients.into_iter().zip(scales).map(|(p, s)| p * s).collect();
        assert_eq!(scaled.len(), (m + 1) * (n + 1), "coefficient count");
        Self { degree, scaled }
    }

    /// Degree in u and v.
    pub fn degree(&self) -> [usize; 2] {
        self.degree
    }

    /// The ordinary Bernstein coefficients, u outermost.
    pub fn coefficients(&self) -> Vec<T> {
        let [row, column] = self.degree.map(binomials);
        let scales = row.iter().flat_map(|r| column.iter().map(move |c| 1.0 / (r * c)));
        self.scaled.iter().zip(scales).map(|(&p, s)| p * s).collect()
    }

    /// Value at (u, v), by de Casteljau.
    pub fn value(&self, u: f64, v: f64) -> T {
        let stride = self.degree[1] + 1;
        let lerp = |line: &mut [T], t: f64| {
            for level in 1..line.len() {
                for k in 0..line.len() - level {
                    line[k] = line[k] * (1.0 - t) + line[k + 1] * t;
                }
            }
            line[0]
        };
        let mut column: Vec<T> = self.coefficients().chunks_mut(stride).map(|row| lerp(row, v)).collect();
        lerp(&mut column, u)
    }

    /// Partial derivative along `axis` (0: u, 1: v); a constant gives the zero constant.
    pub fn derivative(&self, axis: usize) -> Self {
        let [m, n] = self.degree;
        let count = self.degree[axis];
        if count == 0 {
            return Self { degree: self.degree, scaled: vec![T::default(); self.scaled.len()] };
        }
        let mut degree = self.degree;
        degree[axis] -= 1;
        let step = if axis == 0 { n + 1 } else { 1 };
        let mut scaled = Vec::with_capacity((m + 1) * (n + 1));
        for i in 0..=degree[0] {
            for j in 0..=degree[1] {
                let (k, at) = ([i, j][axis], i * (n + 1) + j);
                // C(d-1, k) d (c_{k+1} - c_k), written in scaled coefficients.
                scaled.push(self.scaled[at + step] * (k + 1) as f64 - self.scaled[at] * (count - k) as f64);
            }
        }
        Self { degree, scaled }
    }

    /// The product with a scalar polynomial.
    pub fn product(&self, factor: &Bernstein<f64>) -> Self {
        self.convolved(factor, |c, f| c * f)
    }

    /// Any product that is linear in both factors.
    fn convolved<U: Copy, V: Coefficient>(&self, factor: &Bernstein<U>, times: impl Fn(T, U) -> V) -> Bernstein<V> {
        let [m, n] = self.degree;
        let [k, l] = factor.degree;
        let stride = n + l + 1;
        let mut scaled = vec![V::default(); (m + k + 1) * stride];
        for (i, row) in self.scaled.chunks_exact(n + 1).enumerate() {
            for (h, factors) in factor.scaled.chunks_exact(l + 1).enumerate() {
                let out = &mut scaled[(i + h) * stride..][..stride];
                for (j, &f) in factors.iter().enumerate() {
                    for (o, &c) in out[j..].iter_mut().zip(row) {
                        *o = *o + times(c, f);
                    }
                }
            }
        }
        Bernstein { degree: [m + k, n + l], scaled }
    }

    /// The same polynomial with degree `degree`, at least its own in each direction.
    pub fn elevate(self, degree: [usize; 2]) -> Self {
        if degree == self.degree {
            return self;
        }
        let by = [0, 1].map(|axis| degree[axis].checked_sub(self.degree[axis]).expect("elevation lowers the degree"));
        self.product(&Bernstein::new(by, std::iter::repeat_n(1.0, (by[0] + 1) * (by[1] + 1))))
    }

    /// `self + other * factor`, at the larger degree of the two in each direction.
    pub fn plus(self, other: Self, factor: f64) -> Self {
        let degree = [0, 1].map(|axis| self.degree[axis].max(other.degree[axis]));
        let mut sum = self.elevate(degree);
        for (a, b) in sum.scaled.iter_mut().zip(other.elevate(degree).scaled) {
            *a = *a + b * factor;
        }
        sum
    }
}

impl Bernstein<DVec3> {
    /// The vector product.
    pub fn cross(&self, other: &Self) -> Self {
        self.convolved(other, DVec3::cross)
    }
}

/// `S_uu`, `S_uv`, `S_vv` of the rational surface as patches over the same parameters in [0, 1]²: the hulls of their
/// nets hold them (up to rounding: some 1e-15 of the net's size about its centre times `degree²`, times the cube of the
/// weights' ratio).
///
/// Polynomial nets: second differences. Rational nets: the numerator of the quotient rule over the cube of the weight,
/// which is Guthe 2005 section 5.2 with the division moved inside the hull.
pub fn second_derivatives(net: Net) -> [BezierPatch; 3] {
    if net.is_rational() { rational_derivatives(net) } else { polynomial_derivatives(net) }
}

fn polynomial_derivatives(net: Net) -> [BezierPatch; 3] {
    let [m, n] = net.degree();
    let inverse = 1.0 / net.point(0, 0).w;
    let difference = |steps: [usize; 2], weights: &[(usize, usize, f64)], scale: f64| {
        if m < steps[0] || n < steps[1] {
            return BezierPatch::from_points([0, 0], vec![DVec4::W]);
        }
        let mut points = Vec::with_capacity((m + 1 - steps[0]) * (n + 1 - steps[1]));
        for i in 0..=m - steps[0] {
            for j in 0..=n - steps[1] {
                let sum: DVec4 = weights.iter().map(|&(a, b, s)| net.point(i + a, j + b) * s).sum();
                points.push((sum.truncate() * (scale * inverse)).extend(1.0));
            }
        }
        BezierPatch::from_points([m - steps[0], n - steps[1]], points)
    };
    let second = |degree: usize| (degree * degree.saturating_sub(1)) as f64;
    [
        difference([2, 0], &[(0, 0, 1.0), (1, 0, -2.0), (2, 0, 1.0)], second(m)),
        difference([1, 1], &[(0, 0, 1.0), (1, 0, -1.0), (0, 1, -1.0), (1, 1, 1.0)], (m * n) as f64),
        difference([0, 2], &[(0, 0, 1.0), (0, 1, -2.0), (0, 2, 1.0)], second(n)),
    ]
}

fn rational_derivatives(net: Net) -> [BezierPatch; 3] {
    let degree = net.degree();
    // About the net's centre: terms of the quotient rule cancel, and what cancels should be small.
    let center = net.hull().sum::<DVec3>() / net.points().len() as f64;
    let p = Bernstein::new(degree, net.points().iter().map(|q| q.truncate() - center * q.w));
    let w = Bernstein::new(degree, net.points().iter().map(|q| q.w));
    let cube = w.product(&w).product(&w);
    let weights = [0, 1].map(|a| w.derivative(a));
    // S_a = D_a / w² with D_a = P_a w - P w_a, and S_ab = (D_ab w - 2 D_a w_b) / w³, where D_ab is D_a's derivative.
    let first = [0, 1].map(|a| p.derivative(a).product(&w).plus(p.product(&weights[a]), -1.0));
    let second = |a: usize, b: usize| {
        let numerator = first[a].derivative(b).product(&w).plus(first[a].product(&weights[b]), -2.0);
        let numerator = numerator.elevate(cube.degree).coefficients();
        let points = numerator.into_iter().zip(cube.coefficients()).map(|(q, c)| q.extend(c));
        BezierPatch::from_points(cube.degree, points.collect())
    };
    [second(0, 0), second(0, 1), second(1, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_sums_and_derivatives_agree_with_values() {
        let a = Bernstein::new([2, 1], (0..6).map(|k| (k as f64 * 1.7).sin()));
        let b = Bernstein::new([1, 3], (0..8).map(|k| (k as f64 * 0.9).cos()));
        let (u, v, h) = (0.3, 0.8, 1e-5);
        let close = |x: f64, y: f64, eps: f64| assert!((x - y).abs() < eps, "{x} {y}");
        close(a.product(&b).value(u, v), a.value(u, v) * b.value(u, v), 1e-15);
        close(a.clone().elevate([5, 7]).value(u, v), a.value(u, v), 1e-15);
        close(a.clone().plus(b.clone(), -2.0).value(u, v), a.value(u, v) - 2.0 * b.value(u, v), 1e-15);
        close(b.derivative(1).value(u, v), (b.value(u, v + h) - b.value(u, v - h)) / (2.0 * h), 1e-9);
        close(a.derivative(0).value(u, v), (a.value(u + h, v) - a.value(u - h, v)) / (2.0 * h), 1e-9);
    }

    #[test]
    fn bilinear_patches_have_only_twist() {
        let points: Vec<DVec4> = [0.0, 1.0, 1.0, 3.0].map(|z| DVec4::new(1.0, 2.0, z, 1.0)).to_vec();
        let hulls = second_derivatives(Net::new([1, 1], &points)).map(|d| d.net().hull().collect::<Vec<_>>());
        assert_eq!(hulls, [vec![DVec3::ZERO], vec![DVec3::Z], vec![DVec3::ZERO]]);
    }
}
