//! Patches on uniform grids, for the kernels that evaluate points with normals: what ETER's table 1 times.

use super::abi;
use crate::stages::basis::bernstein;
use foldhash::HashMap;
use std::collections::hash_map::Entry;

/// Quads along one side of a meshlet.
const MESHLET: u16 = abi::MESHLET_VERTICES as u16 - 1;

/// What the kernels of `kernels/surface.cuh` are given.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    pub patches: Vec<abi::Patch>,
    pub meshlets: Vec<abi::Meshlet>,
    pub nets: Vec<abi::Point>,
    /// Bernstein values of grid lines, as `abi::Patch::basis` says.
    pub basis: Vec<f32>,
    /// Their derivatives, at the same places.
    pub slopes: Vec<f32>,
    /// Vertices of all meshlets.
    pub points: usize,
    /// Where the values of a degree and a number of quads lie.
    places: HashMap<(u8, u16), u32>,
}

impl Surfaces {
    /// Adds a patch: its net, v innermost, cut into meshlets of up to 7 x 7 quads.
    pub fn push(&mut self, net: &[abi::Point], degree: [u8; 2], quads: [u16; 2]) {
        let basis = [0, 1].map(|k| self.lines(degree[k], quads[k]));
        let patch = self.patches.len() as u32;
        self.patches.push(abi::Patch { net: self.nets.len() as u32, basis, quads, degree, ..abi::Patch::default() });
        self.nets.extend_from_slice(net);
        for u in (0..quads[0]).step_by(MESHLET.into()) {
            for v in (0..quads[1]).step_by(MESHLET.into()) {
                let size = [quads[0] - u, quads[1] - v].map(|n| n.min(MESHLET));
                self.meshlets.push(abi::Meshlet {
                    patch,
                    vertices: self.points as u32,
                    first: [u, v],
                    quads: size.map(|n| n as u8),
                    ..abi::Meshlet::default()
                });
                self.points += size.map(|n| usize::from(n) + 1).iter().product::<usize>();
            }
        }
    }

    fn lines(&mut self, degree: u8, quads: u16) -> u32 {
        let place = match self.places.entry((degree, quads)) {
            Entry::Occupied(entry) => return *entry.get(),
            Entry::Vacant(entry) => *entry.insert(self.basis.len() as u32),
        };
        let n = usize::from(degree);
        let (mut row, mut lower) = (vec![0.0; n + 1], vec![0.0; n]);
        for line in 0..=quads {
            let t = f64::from(line) / f64::from(quads);
            bernstein(t, &mut row);
            bernstein(t, &mut lower);
            self.basis.extend(row.iter().map(|&b| b as f32));
            // B'_i^n = n (B_(i-1)^(n-1) - B_i^(n-1))
            let of_lower = |i: usize| lower.get(i).copied().unwrap_or(0.0);
            let slope = |i: usize| f64::from(degree) * (of_lower(i.wrapping_sub(1)) - of_lower(i));
            self.slopes.extend((0..=n).map(|i| slope(i) as f32));
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_cut_into_meshlets() {
        let mut surfaces = Surfaces::default();
        let net = [abi::Point::default(); 8];
        surfaces.push(&net, [1, 3], [63, 8]);
        surfaces.push(&net, [3, 1], [8, 63]);
        assert_eq!(surfaces.meshlets.len(), 2 * 9 * 2);
        assert_eq!(surfaces.points, 2 * (9 * 8) * (8 + 2));
        // Lines of degree 1 over 63 quads and of degree 3 over 8, once each.
        assert_eq!([surfaces.basis.len(), surfaces.slopes.len()], [64 * 2 + 9 * 4; 2]);
    }

    #[test]
    fn slopes_are_derivatives() {
        let mut surfaces = Surfaces::default();
        surfaces.push(&[abi::Point::default(); 8], [3, 1], [2, 1]);
        assert_eq!(surfaces.slopes[..12], [-3.0, 3.0, 0.0, 0.0, -0.75, -0.75, 0.75, 0.75, 0.0, 0.0, -3.0, 3.0]);
        assert_eq!(surfaces.slopes[12..], [-1.0, 1.0, -1.0, 1.0]);
    }
}
