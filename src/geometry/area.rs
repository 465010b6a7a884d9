//! Area of exact surfaces by adaptive quadrature.

use super::Net;
use glam::DMat3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// An integral with a bound on its error that was estimated, not proved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub error: f64,
}

impl Estimate {
    /// The error as a fraction of the value; 0 where that is 0.
    pub fn relative_error(&self) -> f64 {
        if self.value == 0.0 { 0.0 } else { self.error / self.value }
    }
}

/// Nodes and weights of five-point Gauss-Legendre quadrature on [0, 1]; exact for polynomials up to degree 9.
pub(super) const GAUSS: [(f64, f64); 5] = [
    (0.046910077030668004, 0.11846344252809454),
    (0.23076534494715845, 0.23931433524968324),
    (0.5, 0.28444444444444444),
    (0.7692346550528415, 0.23931433524968324),
    (0.953089922969332, 0.11846344252809454),
];

/// Cells are not quartered more often than this in one patch; what error is left then is stated.
const MAX_SPLITS: usize = 1500;

/// Area of a patch after the linear map `map`, in squared units. The cell whose area changed most when it was quartered
/// is refined next, until those changes add up to at most `tolerance` (squared units); the stated error is their sum.
pub fn patch_area(net: Net, map: DMat3, tolerance: f64) -> Estimate {
    let whole = Cell::new(net, map, UNIT, cell_area(net, map, UNIT));
    let mut error = whole.error;
    let mut cells = BinaryHeap::from([whole]);
    // An error that is not a number ends this too: the patch is out of range, and refining it mends nothing.
    while error > tolerance && cells.len() < 3 * MAX_SPLITS {
        let Some(cell) = cells.pop() else { break };
        error -= cell.error;
        for (quarter, area) in cell.quarters.into_iter().zip(cell.areas) {
            let quarter = Cell::new(net, map, quarter, area);
            error += quarter.error;
            cells.push(quarter);
        }
    }
    let sum = |of: fn(&Cell) -> f64| cells.iter().map(of).sum();
    Estimate { value: sum(|c| c.areas.iter().sum()), error: sum(|c| c.error) }
}

/// Area of a patch with one rule over all of it: its order of magnitude.
pub fn rough_patch_area(net: Net, map: DMat3) -> f64 {
    cell_area(net, map, UNIT)
}

/// A rectangle of parameters: `[[u0, u1], [v0, v1]]`.
type Rectangle = [[f64; 2]; 2];

const UNIT: Rectangle = [[0.0, 1.0], [0.0, 1.0]];

/// A cell with its quarters; the one with the largest error comes first.
struct Cell {
    quarters: [Rectangle; 4],
    areas: [f64; 4],
    /// How much quartering changed the area.
    error: f64,
}

impl Cell {
    /// `coarse` is the area as one rule over the whole cell gives it.
    fn new(net: Net, map: DMat3, cell: Rectangle, coarse: f64) -> Self {
        let halves = cell.map(|[low, high]| [[low, 0.5 * (low + high)], [0.5 * (low + high), high]]);
        let quarters = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| [halves[0][i], halves[1][j]]);
        let areas = quarters.map(|quarter| cell_area(net, map, quarter));
        Self { quarters, areas, error: (areas.iter().sum::<f64>() - coarse).abs() }
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

fn cell_area(net: Net, map: DMat3, [[u0, u1], [v0, v1]]: Rectangle) -> f64 {
    let mut sum = 0.0;
    for (x, wx) in GAUSS {
        for (y, wy) in GAUSS {
            let point = net.surface_point(u0 + x * (u1 - u0), v0 + y * (v1 - v0));
            sum += wx * wy * (map * point.du).cross(map * point.dv).length();
        }
    }
    sum * (u1 - u0) * (v1 - v0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::BezierPatch;
    use glam::DVec4;
    use std::f64::consts::{PI, SQRT_2};

    /// A quarter of a cylinder of radius 1 and height 2.
    fn quarter_cylinder() -> BezierPatch {
        let w = SQRT_2 / 2.0;
        let circle = [(1.0, 0.0, 1.0), (w, w, w), (0.0, 1.0, 1.0)];
        let points = circle.iter().flat_map(|&(x, y, w)| [DVec4::new(x, y, 0.0, w), DVec4::new(x, y, 2.0 * w, w)]);
        BezierPatch::new("cylinder", [2, 1], points.collect()).unwrap()
    }

    #[test]
    fn cylinder_has_its_area() {
        let patch = quarter_cylinder();
        let area = patch_area(patch.net(), DMat3::IDENTITY, 1e-9);
        assert!((area.value - PI).abs() < 1e-12 && area.error < 1e-8, "{area:?}");
        let scaled = patch_area(patch.net(), DMat3::from_diagonal(glam::DVec3::new(1.0, 1.0, 3.0)), 1e-9);
        assert!((scaled.value - 3.0 * PI).abs() < 1e-11, "{scaled:?}");
    }

    #[test]
    fn rule_is_exact_to_degree_nine() {
        for degree in 0..10 {
            let sum: f64 = GAUSS.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-15, "degree {degree}: {sum}");
        }
    }
}
