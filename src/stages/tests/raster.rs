//! Coverage: every pixel by exact integers, the top-left rule restated as an infinitesimal move.

use super::*;
use crate::stages::topology::{depth_of, index_of};

const SIZE: [u32; 2] = [40, 36];
const PEN: Pen = Pen { sides: [64; 4], radius: 64, fold: 0, off: 0.0 };

/// The top-left rule says: a triangle has what lies a hair to the right, and a far smaller hair below, of its points.
fn covers(corners: &[Vertex; 3], p: [i128; 2]) -> bool {
    let c = corners.each_ref().map(place);
    let turn = area(c[0], c[1], c[2]).signum();
    turn != 0
        && (0..3).all(|k| {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            // The signed area as a polynomial in the hairs: its value, then its slopes in x and in y.
            let terms = [area(a, b, p), a[1] - b[1], b[0] - a[0]].map(|t| t * turn);
            terms.into_iter().find(|&t| t != 0).is_some_and(|t| t > 0)
        })
}

fn check(corners: [Vertex; 3]) -> usize {
    let targets = draw(corners, PEN, Fill::Off, SIZE);
    let mut covered = 0;
    for (&word, p) in targets.near.iter().zip(centers(SIZE)) {
        assert_eq!(word != 0, covers(&corners, p), "{corners:?} at {p:?}");
        if word != 0 {
            covered += 1;
            assert_eq!(index_of(word), 0);
            check_depth(&corners, p, depth_of(word));
        }
    }
    assert!(targets.spare.iter().all(|&word| word == 0), "nothing fills with --fill off");
    covered
}

fn check_depth(corners: &[Vertex; 3], p: [i128; 2], found: f32) {
    let c = corners.each_ref().map(place);
    let all = area(c[0], c[1], c[2]) as f64;
    let share = |k: usize| area(c[(k + 1) % 3], c[(k + 2) % 3], p) as f64 / all;
    let wanted: f64 = (0..3).map(|k| share(k) * f64::from(corners[k].depth)).sum();
    assert!((f64::from(found) - wanted).abs() <= 1e-6 * wanted, "{corners:?} at {p:?}: {found}, not {wanted}");
}

#[test]
fn random_triangles_cover_what_exact_integers_say() {
    let mut random = Random(1);
    let covered: usize = (0..4000).map(|_| check([(); 3].map(|()| random.vertex(-8, 48)))).sum();
    assert!(covered > 100_000, "the triangles missed the picture: {covered} pixels");
}

#[test]
fn slivers_huge_and_degenerate_triangles_too() {
    let mut random = Random(2);
    for k in 0..4000 {
        let mut corners = [(); 3].map(|()| random.vertex(-8, 48));
        match k % 4 {
            // A corner a few sub-pixels off the opposite edge.
            0 => {
                let [a, b, c] = &mut corners;
                c.x = a.x.midpoint(b.x) + random.below(5) as i32 - 2;
                c.y = a.y.midpoint(b.y) + random.below(5) as i32 - 2;
            }
            // As far out as the guard band lets them.
            1 => corners = [(); 3].map(|()| random.vertex(-(1 << 20), 1 << 20)),
            2 => corners[0] = random.vertex(-(1 << 20), 1 << 20),
            _ => corners[2] = corners[k / 4 % 2],
        }
        check(corners);
    }
}

#[test]
fn a_triangulated_region_is_covered_exactly_once() {
    // Cells of 8 pixels that reach past the picture, their corners moved but not so far that a triangle turns over.
    let mut random = Random(3);
    for _ in 0..40 {
        const CELLS: usize = 8;
        let mut grid = [[Vertex::default(); CELLS + 1]; CELLS + 1];
        for (i, row) in grid.iter_mut().enumerate() {
            for (j, vertex) in row.iter_mut().enumerate() {
                let at = |k: usize, random: &mut Random| (k as i32 - 1) * 8 * 256 + random.coordinate(-1, 2);
                *vertex = Vertex { x: at(i, &mut random), y: at(j, &mut random), depth: 0.5, weight: 1.0 };
            }
        }
        let mut count = vec![0u32; (SIZE[0] * SIZE[1]) as usize];
        let mut add = |corners: [Vertex; 3]| {
            let drawn = draw(corners, PEN, Fill::Off, SIZE).near;
            count.iter_mut().zip(drawn).for_each(|(count, word)| *count += u32::from(word != 0));
        };
        for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
            let [p, q, r, s] = [grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]];
            if random.below(2) == 0 {
                add([p, q, r]);
                add([s, r, p]);
            } else {
                add([q, p, s]);
                add([q, r, s]);
            }
        }
        assert!(count.iter().all(|&count| count == 1), "{count:?}");
    }
}

#[test]
fn conservative_fragments_are_the_touched_pixels_that_are_not_covered() {
    let mut random = Random(4);
    for _ in 0..1500 {
        let corners = [(); 3].map(|()| random.vertex(-4, 44));
        let targets = draw(corners, PEN, Fill::Conservative, SIZE);
        for ((&near, &spare), p) in targets.near.iter().zip(&targets.spare).zip(centers(SIZE)) {
            assert_eq!(near != 0, covers(&corners, p), "{corners:?} at {p:?}");
            // The harness' second triangle, without area, leaves a trace too.
            let [a, _, c] = corners;
            let wanted = (near == 0 && touches(&corners, p)) || touches(&[a, c, a], p);
            assert_eq!(spare != 0, wanted, "{corners:?} at {p:?}");
        }
    }
}

/// The closed square about p meets the closed triangle: no edge of either, and no side of the square, separates them.
fn touches(corners: &[Vertex; 3], p: [i128; 2]) -> bool {
    let c = corners.each_ref().map(place);
    let square = [[-128, -128], [128, -128], [128, 128], [-128, 128]].map(|[x, y]| [p[0] + x, p[1] + y]);
    let edges = (0..3).map(|k| (c[k], c[(k + 1) % 3])).chain((0..4).map(|k| (square[k], square[(k + 1) % 4])));
    !edges.filter(|(a, b)| a != b).any(|(a, b)| {
        let side = |points: &[[i128; 2]]| {
            let values = points.iter().map(|&q| area(a, b, q));
            (values.clone().min().unwrap_or(0), values.max().unwrap_or(0))
        };
        let ((low, high), (square_low, square_high)) = (side(&c), side(&square));
        high < square_low || square_high < low
    })
}
