//! Speed against error: one point a configuration, and those that nothing beats in both.

use super::Row;
use crate::stages::{Bound, Grid};

/// A configuration over all shots it drew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub bound: Bound,
    pub grid: Grid,
    pub tolerance: f64,
    /// Mean over the shots of the median frame time.
    pub ms: f64,
    /// Largest grid error over the shots, in pixels.
    pub error: f64,
    pub quads: u64,
    pub triangles: u64,
}

/// Sums the rows up by bound, grid and tolerance, in order of appearance. A configuration that was refused somewhere
/// is left out: its mean would be over other shots than its rivals'.
pub fn points(rows: &[Row]) -> Vec<Point> {
    let key = |row: &Row| (row.setting.bound, row.setting.grid, row.setting.tolerance);
    let mut keys = Vec::new();
    for row in rows {
        if !keys.contains(&key(row)) {
            keys.push(key(row));
        }
    }
    keys.into_iter().filter_map(|k| point(&rows.iter().filter(|r| key(r) == k).collect::<Vec<_>>())).collect()
}

fn point(rows: &[&Row]) -> Option<Point> {
    let first = rows.first()?.setting;
    let mut point = Point {
        bound: first.bound,
        grid: first.grid,
        tolerance: first.tolerance,
        ms: 0.0,
        error: 0.0,
        quads: 0,
        triangles: 0,
    };
    for row in rows {
        let measured = row.measured()?;
        point.ms += measured.total.median / rows.len() as f64;
        // A shot that shows nothing has no error.
        point.error = point.error.max(measured.errors.as_ref()?.grid_max().unwrap_or(0.0));
        point.quads += measured.counts.quads;
        point.triangles += measured.counts.triangles;
    }
    Some(point)
}

/// The points that no other beats in both time and error, from the fastest to the most exact.
pub fn pareto(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.ms.total_cmp(&b.ms).then(a.error.total_cmp(&b.error)));
    let mut least = f64::INFINITY;
    sorted.retain(|p| {
        let better = p.error < least;
        least = least.min(p.error);
        better
    });
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::testing::{refused, row};

    #[test]
    fn a_point_is_mean_time_and_worst_error() {
        let rows = [
            row(Bound::Eter, Grid::Eter, 0.5, 10.0, 0.1),
            row(Bound::Eter, Grid::Eter, 0.5, 30.0, 0.3),
            row(Bound::Eter, Grid::Eter, 1.0, 5.0, 0.6),
            refused(Bound::Slefe, "rational"),
        ];
        let points = points(&rows);
        assert_eq!(points.len(), 2);
        assert_eq!((points[0].ms, points[0].error, points[0].quads), (20.0, 0.3, 200));
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let at = |ms, error| point(&[&row(Bound::Screen, Grid::Variable, 0.5, ms, error)]).unwrap();
        let front = pareto(&[at(3.0, 0.1), at(1.0, 0.5), at(2.0, 0.6), at(2.0, 0.3), at(4.0, 0.1)]);
        let times: Vec<f64> = front.iter().map(|p| p.ms).collect();
        assert_eq!(times, [1.0, 2.0, 3.0]);
    }
}
