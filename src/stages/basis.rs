//! Bernstein values on uniform grids, computed in f64 and rounded once.

use std::sync::OnceLock;

/// Degrees and grid sizes whose tables are kept; larger ones are made on the spot.
const KEPT_DEGREE: usize = 8;
const KEPT_QUADS: usize = 64;

/// Tables of `B_i^degree(k / quads)`, made when first asked for.
#[derive(Debug)]
pub(crate) struct BasisTables {
    kept: Vec<OnceLock<Box<[f32]>>>,
}

impl BasisTables {
    pub fn new() -> Self {
        let size = (KEPT_DEGREE + 1) * (KEPT_QUADS + 1);
        Self { kept: std::iter::repeat_with(OnceLock::new).take(size).collect() }
    }

    /// Calls `use_table` with rows of `degree + 1` values, one row per grid line `k = 0..=quads`.
    pub fn with<R>(&self, degree: usize, quads: u32, use_table: impl FnOnce(&[f32]) -> R) -> R {
        let quads = quads as usize;
        if degree <= KEPT_DEGREE && quads <= KEPT_QUADS {
            let cell = &self.kept[degree * (KEPT_QUADS + 1) + quads];
            use_table(cell.get_or_init(|| table(degree, quads)))
        } else {
            use_table(&table(degree, quads))
        }
    }
}

fn table(degree: usize, quads: usize) -> Box<[f32]> {
    let mut values = Vec::with_capacity((quads + 1) * (degree + 1));
    let mut row = vec![0.0f64; degree + 1];
    for k in 0..=quads {
        bernstein(k as f64 / quads as f64, &mut row);
        values.extend(row.iter().map(|&b| b as f32));
    }
    values.into()
}

/// All Bernstein polynomials of degree `row.len() - 1` at t, by the triangular recurrence (no cancellation).
pub(crate) fn bernstein(t: f64, row: &mut [f64]) {
    row[0] = 1.0;
    for d in 1..row.len() {
        let mut carried = 0.0;
        for b in &mut row[..d] {
            let old = *b;
            *b = carried + (1.0 - t) * old;
            carried = t * old;
        }
        row[d] = carried;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_sum_to_one_and_interpolate_the_ends() {
        for degree in [1, 3, 8, 25] {
            BasisTables::new().with(degree, 13, |table| {
                for row in table.chunks(degree + 1) {
                    let sum: f64 = row.iter().map(|&b| f64::from(b)).sum();
                    assert!((sum - 1.0).abs() < 1e-6, "degree {degree}: {sum}");
                }
                assert_eq!(table[0], 1.0);
                assert_eq!(table[table.len() - 1], 1.0);
            });
        }
    }
}
