//! Yeo's equation 11: the time of a frame as a constant and a share for each patch, each triangle and each drawn pixel.

use crate::report::{Cell, Measured, Table};

/// What a frame's time is made of: 1, visible patches, triangles, drawn pixels.
const TERMS: usize = 4;

/// Coefficients that fit best, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Milliseconds: at all, a patch, a triangle, a pixel.
    pub coefficients: [f64; TERMS],
    /// Part of the variance that they explain.
    pub r2: f64,
    /// Largest error over the measured time.
    pub worst: f64,
    pub frames: usize,
}

/// What the time of a measured frame depends on, and the time.
pub fn sample(measured: &Measured) -> ([f64; TERMS], f64) {
    let counts = &measured.counts;
    let terms = [1.0, counts.patches_visible as f64, counts.triangles as f64, counts.drawn as f64];
    (terms, measured.total.median)
}

impl Fit {
    /// Least squares of relative errors, as times differ by orders of magnitude; `None` where frames are too few. A term is 0
    /// where frames are too much alike to tell it from others.
    pub fn of(frames: &[([f64; TERMS], f64)]) -> Option<Self> {
        if frames.len() <= TERMS {
            return None;
        }
        // Columns of one size, so that a small pivot means terms that depend on each other.
        let scale: [f64; TERMS] = std::array::from_fn(|k| frames.iter().map(|f| f.0[k].abs()).fold(0.0, f64::max));
        if scale.contains(&0.0) {
            return None;
        }
        let mut rows = [[0.0; TERMS + 1]; TERMS];
        for (terms, ms) in frames {
            let shares: [f64; TERMS] = std::array::from_fn(|k| terms[k] / scale[k] / ms);
            for (row, share) in rows.iter_mut().zip(shares) {
                row.iter_mut().zip(shares).for_each(|(x, other)| *x += share * other);
                row[TERMS] += share;
            }
        }
        // Their size is that of the least time squared.
        let largest = rows.iter().flatten().copied().fold(0.0, f64::max);
        rows.iter_mut().flatten().for_each(|x| *x /= largest);
        let solution = solve(rows);
        let coefficients: [f64; TERMS] = std::array::from_fn(|k| solution[k] / scale[k]);
        let mean = frames.iter().map(|f| f.1).sum::<f64>() / frames.len() as f64;
        let off =
            |(terms, ms): &([f64; TERMS], f64)| terms.iter().zip(coefficients).map(|(t, c)| t * c).sum::<f64>() - ms;
        let rest: f64 = frames.iter().map(|f| off(f).powi(2)).sum();
        let all: f64 = frames.iter().map(|f| (f.1 - mean).powi(2)).sum();
        let worst = frames.iter().map(|f| off(f).abs() / f.1).fold(0.0, f64::max);
        Some(Self { coefficients, r2: 1.0 - rest / all, worst, frames: frames.len() })
    }
}

/// Without the terms that can't be told from others, and then without those that would cost less than nothing.
fn solve(mut rows: System) -> [f64; TERMS] {
    loop {
        let left_out = match eliminate(rows) {
            Ok(solution) => {
                let least = (0..TERMS).min_by(|&a, &b| solution[a].total_cmp(&solution[b])).unwrap_or(0);
                if solution[least] >= 0.0 {
                    return solution;
                }
                least
            }
            Err(dependent) => dependent,
        };
        // Its coefficient is 0.
        rows.iter_mut().for_each(|row| row[left_out] = 0.0);
        rows[left_out] = [0.0; TERMS + 1];
        rows[left_out][left_out] = 1.0;
    }
}

/// Normal equations: a row for each term, the last column their right sides.
type System = [[f64; TERMS + 1]; TERMS];

/// Cholesky's order, without exchanges: a small pivot is a term that depends on those before it, and is returned.
fn eliminate(mut rows: System) -> Result<[f64; TERMS], usize> {
    let size: [f64; TERMS] = std::array::from_fn(|k| rows[k][k]);
    for k in 0..TERMS {
        let pivot = rows[k];
        if pivot[k] <= 1e-6 * size[k] {
            return Err(k);
        }
        for row in &mut rows[k + 1..] {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    let mut solution = [0.0; TERMS];
    for k in (0..TERMS).rev() {
        let known: f64 = (k + 1..TERMS).map(|j| rows[k][j] * solution[j]).sum();
        solution[k] = (rows[k][TERMS] - known) / rows[k][k];
    }
    Ok(solution)
}

/// One line a configuration.
pub fn table(fits: &[(String, Option<Fit>)]) -> Table {
    let mut table = Table::new(&[
        "configuration",
        "frames",
        "ms at all",
        "ns a patch",
        "ns a triangle",
        "ns a pixel",
        "R2",
        "worst",
    ]);
    for (name, fit) in fits {
        let of = |get: &dyn Fn(&Fit) -> Cell| fit.as_ref().map_or(Cell::Missing, get);
        let ns = |k: usize| of(&|f: &Fit| (f.coefficients[k] * 1e6).into());
        table.push(vec![
            name.as_str().into(),
            of(&|f| f.frames.into()),
            of(&|f| f.coefficients[0].into()),
            ns(1),
            ns(2),
            ns(3),
            of(&|f| f.r2.into()),
            of(&|f| format!("{:.0} %", 100.0 * f.worst).into()),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_coefficients_are_found() {
        let time = |[k, p, t, q]: [f64; 4]| 0.25 * k + 2e-5 * p + 3e-6 * t + 1e-6 * q;
        let frames: Vec<_> = (0..8u32)
            .map(|k| {
                let bit = |n: u32| f64::from(k >> n & 1);
                let terms = [1.0, 1e3 + 9e4 * bit(0), 1e4 + 1e6 * bit(1), 1e5 + 5e5 * bit(2)];
                (terms, time(terms))
            })
            .collect();
        let fit = Fit::of(&frames).unwrap();
        for (found, expected) in fit.coefficients.into_iter().zip([0.25, 2e-5, 3e-6, 1e-6]) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{fit:?}");
        }
        assert!(fit.r2 > 0.999_999 && fit.worst < 1e-6);
    }

    #[test]
    fn terms_that_can_not_be_told_apart_are_one() {
        let frames: Vec<_> = (1..9).map(|k| f64::from(k) * 100.0).map(|n| ([1.0, n, 2.0 * n, 5.0], n)).collect();
        let fit = Fit::of(&frames).unwrap();
        assert!((fit.coefficients[1] - 1.0).abs() < 1e-6 && fit.coefficients[2] == 0.0, "{fit:?}");
        assert_eq!(Fit::of(&frames[..3]), None);
    }
}
