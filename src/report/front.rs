//! Speed against error: one point a configuration, and those that nothing beats in both.

use super::{Errors, Measured, Outcome, Row, Setting, Summary, Table, name};
use crate::stages::{Bound, Grid, Trim};
use serde::Serialize;

/// A configuration over all shots it drew.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    pub bound: Bound,
    pub grid: Grid,
    pub trim: Trim,
    pub tolerance: f64,
    /// Mean over the shots of the median frame time.
    pub ms: f64,
    /// Largest grid error over the shots, in pixels.
    pub error: f64,
}

/// The rows of each bound, grid, way to trim and tolerance, in order of appearance.
fn configurations(rows: &[Row]) -> Vec<Vec<&Row>> {
    let key = |row: &Row| (row.setting.bound, row.setting.grid, row.setting.trim, row.setting.tolerance);
    let mut groups: Vec<Vec<&Row>> = Vec::new();
    for row in rows {
        match groups.iter_mut().find(|g| key(g[0]) == key(row)) {
            Some(group) => group.push(row),
            None => groups.push(vec![row]),
        }
    }
    groups
}

/// One point a configuration. One that was refused somewhere is left out: its mean would be over other shots than its
/// rivals'.
pub fn points(rows: &[Row]) -> Vec<Point> {
    configurations(rows).iter().filter_map(|group| point(group)).collect()
}

/// Configurations as a table, refused ones with their reason.
pub fn summary(rows: &[Row]) -> Table {
    let front = pareto(&points(rows));
    let mut table = Table::new(&[
        "bound",
        "grid",
        "trim",
        "t px",
        "ms",
        "quads",
        "triangles",
        "grid max px",
        "refined max px",
        "violations",
        "cracks",
        "covering",
        "depth",
        "front",
        "note",
    ]);
    for group in configurations(rows) {
        let setting = group[0].setting;
        let count = |get: fn(&Measured) -> u64| -> Option<u64> { group.iter().map(|r| r.measured().map(get)).sum() };
        let sum = |get: fn(&Errors) -> u64| -> Option<u64> { group.iter().map(|r| r.errors().map(get)).sum() };
        let worst = |get: fn(&Errors) -> Option<Summary>| {
            group.iter().filter_map(|r| get(r.errors()?)).map(|s| s.max).reduce(f64::max)
        };
        let ms: Option<f64> = group.iter().map(|r| r.measured().map(|m| m.total.median / group.len() as f64)).sum();
        let on_front = point(&group).is_some_and(|p| front.contains(&p));
        let refused = group.iter().find_map(|r| match &r.outcome {
            Outcome::Refused(reason) => Some(format!("refused: {reason}")),
            Outcome::Measured(_) => None,
        });
        table.push(vec![
            name(setting.bound).into(),
            name(setting.grid).into(),
            name(setting.trim).into(),
            setting.tolerance.into(),
            ms.into(),
            count(|m| m.counts.quads).into(),
            count(|m| m.counts.triangles).into(),
            worst(|e| e.grid).into(),
            worst(|e| e.refined).into(),
            sum(|e| e.violations).into(),
            sum(|e| e.cracks).into(),
            sum(|e| e.covering_failures).into(),
            sum(|e| e.depth_failures).into(),
            if on_front { "yes" } else { "" }.into(),
            refused.unwrap_or_default().into(),
        ]);
    }
    table
}

fn point(rows: &[&Row]) -> Option<Point> {
    let Setting { bound, grid, trim, tolerance, .. } = rows.first()?.setting;
    let mut point = Point { bound, grid, trim, tolerance, ms: 0.0, error: 0.0 };
    for row in rows {
        let measured = row.measured()?;
        point.ms += measured.total.median / rows.len() as f64;
        // A shot that shows nothing has no error.
        point.error = point.error.max(measured.errors.as_ref()?.grid_max().unwrap_or(0.0));
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
        assert_eq!((points[0].ms, points[0].error), (20.0, 0.3));
        let table = summary(&rows).markdown();
        assert!(table.contains("refused: rational") && table.lines().count() == 5);
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let at = |ms, error| point(&[&row(Bound::Screen, Grid::Variable, 0.5, ms, error)]).unwrap();
        let front = pareto(&[at(3.0, 0.1), at(1.0, 0.5), at(2.0, 0.6), at(2.0, 0.3), at(4.0, 0.1)]);
        let times: Vec<f64> = front.iter().map(|p| p.ms).collect();
        assert_eq!(times, [1.0, 2.0, 3.0]);
    }
}
