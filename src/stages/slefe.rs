//! slefe: Yeo et al. 2012 (iPASS): widths of piecewise linear enclosures decide the grid. Kept for comparison: it is no
//! guarantee (research "tessellation-bounds", section 3) and covers polynomial patches up to degree 7 only.

use super::bounds::{Constraints, Subject};
use glam::DVec3;

/// Pieces of the enclosure in each direction.
const PIECES: usize = 3;
/// Largest degree the tables cover.
pub(super) const MAX_DEGREE: usize = 7;

/// Upper and lower values at 0, 1/3, 2/3, 1 of the polynomial whose only non-zero second difference is the j-th (1),
/// for degree d = 2..7 and j = 1..d/2; the others mirror. Computed by linear programming in the research folder.
const TABLE: [&[[[f64; PIECES + 1]; 2]]; MAX_DEGREE - 1] = [
    &[[[0.0, -0.2222222, -0.2222222, 0.0], [-0.0277779, -0.2500001, -0.2500001, -0.0277779]]],
    &[[[0.0, -0.3703704, -0.2962963, 0.0], [-0.0695216, -0.439892, -0.3153517, -0.008733]]],
    &[
        [[0.0, -0.4691358, -0.3209877, 0.0], [-0.1170224, -0.5861582, -0.3294661, -0.0023242]],
        [[0.0, -0.5432099, -0.5432099, 0.0], [-0.0132963, -0.6250001, -0.6250001, -0.0132963]],
    ],
    &[
        [[0.0, -0.5349794, -0.3292181, 0.0], [-0.1655551, -0.7005345, -0.3325541, -0.0005223]],
        [[0.0, -0.7407407, -0.617284, 0.0], [-0.0791172, -0.8432771, -0.7198203, -0.0000001]],
    ],
    &[
        [[0.0, -0.5788752, -0.3319616, 0.0], [-0.2125322, -0.7914074, -0.3331833, -0.0001073]],
        [[0.0, -0.8943759, -0.6474623, 0.0], [-0.1486372, -1.043013, -0.709172, -0.0000001]],
        [[0.0, -0.8806584, -0.8806584, 0.0], [-0.0000001, -1.0312501, -1.0312501, -0.0000001]],
    ],
    &[
        [[0.0, -0.608139, -0.3328761, 0.0], [-0.2566554, -0.8647944, -0.333302, -0.0000245]],
        [[0.0, -1.0114312, -0.6593507, 0.0], [-0.2125215, -1.2239526, -0.6688402, -0.0000001]],
        [[0.0, -1.1074531, -0.9474166, 0.0], [-0.0189769, -1.2836326, -1.123596, -0.0000001]],
    ],
];

/// Upper (or lower) enclosure values at the four break points of one row of coefficients.
fn enclose_row(c: &[DVec3], upper: bool) -> [DVec3; PIECES + 1] {
    let d = c.len() - 1;
    let chord = |k: usize| c[0].lerp(c[d], k as f64 / PIECES as f64);
    std::array::from_fn(|k| {
        let mut value = chord(k);
        for j in 1..d {
            let difference = c[j - 1] - c[j] * 2.0 + c[j + 1];
            let (j, k) = if 2 * j <= d { (j, k) } else { (d - j, PIECES - k) };
            let [high, low] = TABLE[d - 2][j - 1];
            let (grows, shrinks) = if upper { (high[k], low[k]) } else { (low[k], high[k]) };
            value += difference.max(DVec3::ZERO) * grows + difference.min(DVec3::ZERO) * shrinks;
        }
        value
    })
}

/// The enclosure of a net by tensor product: values at the 4 x 4 break points.
fn enclose_net(net: &[DVec3], [m, n]: [usize; 2], upper: bool) -> Vec<DVec3> {
    let columns: Vec<[DVec3; PIECES + 1]> =
        (0..=n).map(|j| enclose_row(&(0..=m).map(|i| net[i * (n + 1) + j]).collect::<Vec<_>>(), upper)).collect();
    (0..=PIECES).flat_map(|k| enclose_row(&columns.iter().map(|c| c[k]).collect::<Vec<_>>(), upper)).collect()
}

/// One number of pieces for both directions, from the widest projected enclosure box; Yeo 2012 section 4.
pub(super) fn constraints(subject: &Subject) -> Constraints {
    let Subject { leaf, lens, map, .. } = *subject;
    // Camera space in pixels a unit for x and y, model units for z.
    let camera: Vec<DVec3> = subject.net.points().iter().map(|&p| map.apply(p).truncate() / p.w).collect();
    let high = enclose_net(&camera, leaf.degree, true);
    let low = enclose_net(&camera, leaf.degree, false);
    let mut pixels = 0.0f64;
    let mut depth = 0.0f64;
    for (h, l) in high.iter().zip(&low) {
        let corner = |k: usize| DVec3::new(pick(k & 1, l.x, h.x), pick(k & 2, l.y, h.y), pick(k & 4, l.z, h.z));
        let project = |c: DVec3| if lens.perspective { c.truncate() / c.z.max(lens.near) } else { c.truncate() };
        let corners: [_; 8] = std::array::from_fn(|k| project(corner(k)));
        let size =
            corners.iter().fold(corners[0], |a, &b| a.max(b)) - corners.iter().fold(corners[0], |a, &b| a.min(b));
        pixels = pixels.max(size.max_element());
        depth = depth.max(h.z - l.z);
    }
    let share = (pixels / (2.0 * subject.tolerance)).max(depth / (2.0 * subject.depth_tolerance));
    let pieces = (PIECES * PIECES) as f64 * share;
    Constraints::isotropic(pieces)
}

fn pick(bit: usize, low: f64, high: f64) -> f64 {
    if bit == 0 { low } else { high }
}
