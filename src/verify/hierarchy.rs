//! A hierarchy of boxes in the image: a ray is a point there.

use super::piece::ImageBox;
use glam::DVec2;

/// Boxes in depth-first order; a ray that misses a node goes on at `skip`.
#[derive(Debug, Default)]
pub(super) struct Hierarchy {
    nodes: Vec<Node>,
    /// Items in the order of the leaves, with their boxes.
    items: Vec<(ImageBox, u32)>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: ImageBox,
    skip: u32,
    /// Items of a leaf; empty in inner nodes.
    first: u32,
    count: u32,
}

const ITEMS_PER_LEAF: usize = 4;

impl Hierarchy {
    /// Over items 0, 1, ... with these boxes.
    pub fn new(boxes: impl Iterator<Item = ImageBox>) -> Self {
        let mut items: Vec<_> = boxes.zip(0..).collect();
        let mut nodes = Vec::with_capacity(if items.len() <= ITEMS_PER_LEAF { 1 } else { items.len() });
        if !items.is_empty() {
            build(&mut nodes, &mut items, 0);
        }
        Self { nodes, items }
    }

    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.items.capacity() * size_of::<(ImageBox, u32)>()
    }

    /// Calls `visit(item, its box)` for every item whose box, `slack` wider, holds `p`.
    pub fn visit<'a>(&'a self, p: DVec2, slack: f64, mut visit: impl FnMut(u32, &'a ImageBox)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !node.bounds.contains(p, slack) {
                at = node.skip as usize;
                continue;
            }
            for (bounds, item) in &self.items[node.first as usize..(node.first + node.count) as usize] {
                if bounds.contains(p, slack) {
                    visit(*item, bounds);
                }
            }
            at += 1;
        }
    }
}

/// Appends the tree over `items`, which start at `first` in all items. Halves at the median, so depth is log2.
fn build(nodes: &mut Vec<Node>, items: &mut [(ImageBox, u32)], first: usize) {
    let bounds = items.iter().fold(ImageBox::EMPTY, |all, (b, _)| all.union(*b));
    let at = nodes.len();
    let leaf = items.len() <= ITEMS_PER_LEAF;
    let count = if leaf { items.len() } else { 0 };
    nodes.push(Node { bounds, skip: 0, first: first as u32, count: count as u32 });
    if !leaf {
        let size = bounds.size();
        let axis = usize::from(size.y > size.x);
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |(a, i), (b, j)| {
            a.center()[axis].total_cmp(&b.center()[axis]).then(i.cmp(j))
        });
        let (low, high) = items.split_at_mut(middle);
        build(nodes, low, first);
        build(nodes, high, first + middle);
    }
    nodes[at].skip = nodes.len() as u32;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_a_scan_finds() {
        let boxes: Vec<_> = (0..500)
            .map(|i| {
                let low = DVec2::new(f64::from(i * 37 % 101), f64::from(i * 53 % 97));
                let size = DVec2::new(f64::from(i % 7), f64::from(i % 11));
                ImageBox { low, high: low + size, depth: f64::from(i) }
            })
            .collect();
        let tree = Hierarchy::new(boxes.iter().copied());
        for i in 0..400 {
            let p = DVec2::new(f64::from(i % 20) * 5.5, f64::from(i / 20) * 5.5);
            let mut found = Vec::new();
            tree.visit(p, 0.0, |item, bounds| {
                assert_eq!(bounds.depth, f64::from(item));
                found.push(item as usize);
            });
            found.sort_unstable();
            let expected: Vec<_> = (0..boxes.len()).filter(|&k| boxes[k].contains(p, 0.0)).collect();
            assert_eq!(found, expected);
        }
        Hierarchy::new(std::iter::empty()).visit(DVec2::ZERO, 0.0, |_, _| panic!("nothing is there"));
    }
}
