//! Areas of trimmed faces by Green's theorem: along the loops, of the integral of the area element across.

use crate::model::{Face, SurfacePatch};
use glam::DVec2;

/// Nodes and weights of Gauss-Legendre quadrature with ten nodes on [0, 1] (half of them, the rest by symmetry).
const GAUSS: [(f64, f64); 5] = [
    (0.5 * (1.0 - 0.973_906_528_517_171_7), 0.5 * 0.066_671_344_308_688_14),
    (0.5 * (1.0 - 0.865_063_366_688_984_5), 0.5 * 0.149_451_349_150_580_6),
    (0.5 * (1.0 - 0.679_409_568_299_024_4), 0.5 * 0.219_086_362_515_982_04),
    (0.5 * (1.0 - 0.433_395_394_129_247_2), 0.5 * 0.269_266_719_309_996_36),
    (0.5 * (1.0 - 0.148_874_338_981_631_2), 0.5 * 0.295_524_224_714_752_87),
];

fn gauss() -> impl Iterator<Item = (f64, f64)> + Clone {
    GAUSS.into_iter().flat_map(|(x, w)| [(x, w), (1.0 - x, w)])
}

/// Loops are closed, bit for bit.
pub fn closed(face: &Face) {
    for curves in face.loops.iter().map(|l| &l.curves) {
        for (k, curve) in curves.iter().enumerate() {
            let next = &curves[(k + 1) % curves.len()].curve;
            let (end, start) = (curve.curve.points()[curve.curve.degree()], next.points()[0]);
            assert_eq!((end.w, start.w), (1.0, 1.0), "end weights");
            assert_eq!(end, start, "curve {k} of {} ends where the next starts", curves.len());
        }
    }
}

/// The area element at a point of a patch, by the plane's coordinates.
fn element(patch: &SurfacePatch, p: DVec2) -> f64 {
    let [[u0, u1], [v0, v1]] = patch.domain;
    let at = patch.patch.net().surface_point((p.x - u0) / (u1 - u0), (p.y - v0) / (v1 - v0));
    at.du.cross(at.dv).length() / ((u1 - u0) * (v1 - v0))
}

/// Integral of the area element over `[from, u]` at fixed v.
fn across(face: &Face, p: DVec2) -> f64 {
    let mut sum = 0.0;
    for patch in &face.surface.patches {
        let [[u0, u1], [v0, v1]] = patch.domain;
        let eps = 1e-12 * (v1 - v0);
        let end = p.x.min(u1);
        if p.y < v0 - eps || p.y > v1 + eps || end <= u0 {
            continue;
        }
        // A border between two rows is in both.
        let rows = face.surface.patches.iter().filter(|q| q.domain[0] == patch.domain[0]);
        let rows = rows.filter(|q| p.y >= q.domain[1][0] - eps && p.y <= q.domain[1][1] + eps).count();
        for half in 0..2 {
            let (a, b) = (u0 + 0.5 * f64::from(half) * (end - u0), u0 + 0.5 * f64::from(half + 1) * (end - u0));
            let part: f64 = gauss().map(|(x, w)| w * element(patch, DVec2::new(a + x * (b - a), p.y))).sum();
            sum += part * (b - a) / rows as f64;
        }
    }
    sum
}

/// Area of the face inside its loops; loops inside an odd number of others count as holes by their sign.
pub fn area(face: &Face) -> f64 {
    if face.loops.is_empty() {
        let mut sum = 0.0;
        for patch in &face.surface.patches {
            let [[u0, u1], [v0, v1]] = patch.domain;
            for (x, wx) in gauss() {
                for (y, wy) in gauss() {
                    sum += wx
                        * wy
                        * (u1 - u0)
                        * (v1 - v0)
                        * element(patch, DVec2::new(u0 + x * (u1 - u0), v0 + y * (v1 - v0)));
                }
            }
        }
        return sum;
    }
    let mut total = 0.0;
    for curve in face.loops.iter().flat_map(|l| &l.curves) {
        // The integrand has kinks where the curve crosses from one patch to another: many short parts.
        let parts = 24;
        for part in 0..parts {
            for (x, w) in gauss() {
                let (p, d) = curve.curve.tangent((f64::from(part) + x) / f64::from(parts));
                total += w / f64::from(parts) * across(face, p.truncate()) * d.y;
            }
        }
    }
    total.abs()
}
