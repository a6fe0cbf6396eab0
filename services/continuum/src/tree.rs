//! Boxes, halved until few are left in each: what meets a box is found in about log n steps.

use cullet_geometry::Vec3;

/// Most boxes that are not halved further.
const LEAF: usize = 4;

/// Least and greatest coordinates \[m\].
pub type SpaceBox = [Vec3; 2];

/// Boxes in a tree.
#[derive(Clone, Debug)]
pub struct BoxTree {
    /// With the number of each.
    boxes: Vec<(SpaceBox, u32)>,
    /// Each before what is below it.
    nodes: Vec<TreeNode>,
}

#[derive(Clone, Copy, Debug)]
struct TreeNode {
    range: SpaceBox,
    first: usize,
    /// Zero where others are below it.
    count: usize,
    /// The node after all that is below it.
    after: usize,
}

/// Whether two boxes meet, touching included.
fn meet(a: &SpaceBox, b: &SpaceBox) -> bool {
    (0..3).all(|k| a[0][k] <= b[1][k] && b[0][k] <= a[1][k])
}

impl BoxTree {
    /// A tree of boxes, which have the numbers of their order.
    pub fn new(boxes: impl Iterator<Item = SpaceBox>) -> Self {
        let mut tree = Self { boxes: boxes.zip(0..).collect(), nodes: Vec::new() };
        let count = tree.boxes.len();
        tree.grow(0, count);
        tree
    }

    fn grow(&mut self, first: usize, count: usize) {
        let own = &mut self.boxes[first..first + count];
        let start = [Vec3::from([f64::INFINITY; 3]), Vec3::from([f64::NEG_INFINITY; 3])];
        let join = |all: SpaceBox, (b, _): &(SpaceBox, u32)| [all[0].inf(&b[0]), all[1].sup(&b[1])];
        let range = own.iter().fold(start, join);
        let node = self.nodes.len();
        let halved = count > LEAF;
        let kept = if halved { 0 } else { count };
        if halved {
            let axis = (range[1] - range[0]).imax();
            let middle = |b: &(SpaceBox, u32)| b.0[0][axis] + b.0[1][axis];
            own.select_nth_unstable_by(count / 2, |a, b| middle(a).total_cmp(&middle(b)));
        }
        self.nodes.push(TreeNode { range, first, count: kept, after: 0 });
        if halved {
            self.grow(first, count / 2);
            self.grow(first + count / 2, count - count / 2);
        }
        self.nodes[node].after = self.nodes.len();
    }

    /// Calls `found` with the number of each box that meets a range, in no order that means
    /// anything, until it says true; whether it did.
    pub fn find(&self, range: &SpaceBox, mut found: impl FnMut(u32) -> bool) -> bool {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !meet(&node.range, range) {
                at = node.after;
                continue;
            }
            for (own, number) in &self.boxes[node.first..node.first + node.count] {
                if meet(own, range) && found(*number) {
                    return true;
                }
            }
            at += 1;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::{BoxTree, SpaceBox, meet};
    use cullet_geometry::Vec3;
    use cullet_geometry::math::unit;

    #[test]
    fn all_that_meets_a_box_is_found() {
        let chance = |n: u64, k: u64| unit(5, k, n);
        let boxes: Vec<SpaceBox> = (0..300)
            .map(|n| {
                let low = Vec3::new(chance(n, 0), chance(n, 1), chance(n, 2));
                [low, low + Vec3::from([0.2 * chance(n, 3); 3])]
            })
            .collect();
        let tree = BoxTree::new(boxes.iter().copied());
        for range in &boxes {
            let mut found = Vec::new();
            tree.find(range, |number| {
                found.push(number);
                false
            });
            found.sort_unstable();
            let all = (0..300).filter(|&n| meet(&boxes[n as usize], range));
            assert!(found.iter().copied().eq(all));
        }
        assert!(!BoxTree::new(std::iter::empty()).find(&boxes[0], |_| true));
    }
}
