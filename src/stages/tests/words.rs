//! The low 7 bits of a visibility word, for every shape that a meshlet can have.

use super::*;
use crate::stages::topology::*;
use std::collections::HashSet;

fn shapes() -> impl Iterator<Item = Meshlet> {
    let sides = (1..=7).flat_map(|u| (1..=7).map(move |v| [u, v]));
    sides.flat_map(|quads| {
        [0, 1].map(|diagonal| Meshlet {
            leaf: 0,
            vertices: 0,
            first: [0, 0],
            quads,
            diagonal,
            hidden: 0,
            tested: false,
            outer: 15,
            columns: [0, 0],
            rows: [0, 0],
        })
    })
}

fn sorted(mut corners: [[usize; 2]; 3]) -> [[usize; 2]; 3] {
    corners.sort_unstable();
    corners
}

#[test]
fn every_triangle_and_edge_is_found_again() {
    for meshlet in shapes() {
        let [across_u, across_v] = meshlet.quads.map(usize::from);
        let (mut indices, mut all) = (HashSet::new(), HashSet::new());
        for (a, b) in (0..across_u).flat_map(|a| (0..across_v).map(move |b| (a, b))) {
            for (k, corners) in triangles(a, b, meshlet.diagonal).into_iter().enumerate() {
                let index = triangle_index(&meshlet, a, b) + k as u32;
                assert_eq!(primitive(&meshlet, index), Primitive::Triangle(corners));
                assert!(indices.insert(index) && all.insert(sorted(corners)) && !is_edge(index.into()));
            }
        }
        for side in 0..4 {
            for k in 0..if side < 2 { across_v } else { across_u } {
                let index = edge_index(side, k);
                let corners = edge(&meshlet, side, k);
                assert_eq!(primitive(&meshlet, index), Primitive::Edge(corners));
                assert!(indices.insert(index) && index <= INDEX_MASK && is_edge(index.into()));
                // The two ends lie on the side, next to each other, and a triangle of the meshlet is behind them.
                let axis = side / 2;
                let line = if side % 2 == 0 { 0 } else { meshlet.quads[axis].into() };
                let ends = [corners[0], corners[1]];
                assert!(ends.iter().all(|end| end[axis] == line));
                assert_eq!(ends.map(|end| end[1 - axis]), [k, k + 1]);
                assert!(all.contains(&sorted(corners)), "{meshlet:?}: {corners:?}");
            }
        }
        assert_eq!(all.len(), 2 * across_u * across_v);
    }
}

#[test]
fn words_keep_their_fields_and_order_by_depth() {
    let mut random = Random(6);
    for _ in 0..100_000 {
        let meshlet = random.below(MAX_MESHLETS) as u32;
        let index = random.below(1 << INDEX_BITS) as u32;
        let [depth, other] = [(); 2].map(|()| random.between(1e-6, 1.0) as f32);
        let found = word(depth, meshlet, index);
        assert_eq!((depth_of(found), meshlet_of(found), index_of(found)), (depth, meshlet, index));
        assert!(depth == other || (word(depth, 0, 0) > word(other, meshlet, index)) == (depth > other));
    }
}
