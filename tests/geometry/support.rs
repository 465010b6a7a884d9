//! Random nets and double-double arithmetic.

#[path = "../support/random.rs"]
mod random;

use glam::{DVec3, DVec4};
use halfpixel::geometry::BezierPatch;
pub use random::Random;
use std::ops::{Add, Mul, Sub};

/// Unit roundoff of f64.
pub const ROUNDOFF: f64 = f64::EPSILON / 2.0;

impl Random {
    pub fn vector(&mut self) -> DVec3 {
        self.point(1.0)
    }

    /// Positions in [-1, 1]³, weights from 1 / `spread` to `spread`.
    pub fn points(&mut self, count: usize, spread: f64) -> Vec<DVec4> {
        let point = |_| {
            let w = spread.powf(self.between(-1.0, 1.0));
            (self.vector() * w).extend(w)
        };
        (0..count).map(point).collect()
    }

    pub fn patch(&mut self, degree: [usize; 2], spread: f64) -> BezierPatch {
        let points = self.points((degree[0] + 1) * (degree[1] + 1), spread);
        BezierPatch::new("random", degree, points).expect("a good patch")
    }
}

/// An unevaluated sum of two doubles, some 106 bits (Dekker 1971; Knuth's TwoSum, FMA for the product).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double {
    pub high: f64,
    pub low: f64,
}

impl Double {
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let b_part = high - a;
        Self { high, low: (a - (high - b_part)) + (b - b_part) }
    }

    pub fn value(self) -> f64 {
        self.high + self.low
    }
}

impl From<f64> for Double {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let s = Self::sum(self.high, other.high);
        let t = Self::sum(self.low, other.low);
        let s = Self::sum(s.high, s.low + t.high);
        Self::sum(s.high, s.low + t.low)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self { high: -other.high, low: -other.low }
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let low = self.high.mul_add(other.high, -high) + (self.high * other.low + self.low * other.high);
        Self::sum(high, low)
    }
}

/// The Bézier curve through `line` at `t`, by de Casteljau.
fn curve(line: &mut [Double], t: Double) -> Double {
    let s = Double::from(1.0) - t;
    for count in (1..line.len()).rev() {
        for k in 0..count {
            line[k] = line[k] * s + line[k + 1] * t;
        }
    }
    line[0]
}

/// Partial derivative of order `orders` of component `axis` of the homogeneous patch at (u, v), from differenced nets.
pub fn partial(patch: &BezierPatch, axis: usize, orders: [usize; 2], u: f64, v: f64) -> Double {
    let [mut m, mut n] = patch.degree();
    if orders[0] > m || orders[1] > n {
        return Double::from(0.0);
    }
    let mut rows: Vec<Vec<Double>> =
        patch.points().chunks_exact(n + 1).map(|row| row.iter().map(|p| p[axis].into()).collect()).collect();
    let mut scale = 1.0;
    for _ in 0..orders[0] {
        let difference = |pair: &[Vec<Double>]| pair[1].iter().zip(&pair[0]).map(|(&a, &b)| a - b).collect();
        rows = rows.windows(2).map(difference).collect();
        scale *= m as f64;
        m -= 1;
    }
    for _ in 0..orders[1] {
        rows = rows.iter().map(|row| row.windows(2).map(|pair| pair[1] - pair[0]).collect()).collect();
        scale *= n as f64;
        n -= 1;
    }
    let mut column: Vec<Double> = rows.iter_mut().map(|row| curve(row, v.into())).collect();
    curve(&mut column, u.into()) * scale.into()
}
