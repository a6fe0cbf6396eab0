//! Parts of a soft shell that are too small to be pieces.

use std::collections::BTreeMap;

/// Components in which crumbs stay with the largest that is left of the piece they were of. A piece
/// of which nothing else is left stays one.
pub(super) fn with_crumbs(mut components: Vec<u32>, crumbs: &[bool], labels: &[u32]) -> Vec<u32> {
    let mut sizes: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for p in (0..labels.len()).filter(|&p| !crumbs[p]) {
        *sizes.entry((labels[p], components[p])).or_default() += 1;
    }
    let mut largest: BTreeMap<u32, (usize, u32)> = BTreeMap::new();
    for (&(label, component), &size) in &sizes {
        let best = largest.entry(label).or_insert((size, component));
        if size > best.0 {
            *best = (size, component);
        }
    }
    for p in (0..labels.len()).filter(|&p| crumbs[p]) {
        let left = largest.get(&labels[p]).map(|&(_, component)| component);
        components[p] = left.unwrap_or(labels.len() as u32 + labels[p]);
    }
    // Their numbers are those of their first points.
    let mut first: BTreeMap<u32, u32> = BTreeMap::new();
    let number = |(p, &c): (usize, &u32)| *first.entry(c).or_insert(p as u32);
    components.iter().enumerate().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::with_crumbs;

    /// Crumbs go with what is left of their piece, though a neighbour of another took them.
    #[test]
    fn crumbs_stay_with_their_piece() {
        let labels = [0, 0, 0, 1, 1, 1];
        let components = vec![0, 1, 1, 0, 4, 4];
        let crumbs = [true, false, false, true, false, false];
        assert_eq!(with_crumbs(components, &crumbs, &labels), [0, 0, 0, 3, 3, 3]);
    }

    /// A piece that is gone, all of whose points bear nothing, takes no other with it.
    #[test]
    fn a_piece_of_crumbs_alone_stays_one() {
        let labels = [2, 0, 0, 2, 0, 2];
        let crumbs = [true, false, false, true, false, true];
        assert_eq!(with_crumbs(vec![0, 1, 1, 0, 4, 4], &crumbs, &labels), [0, 1, 1, 0, 4, 0]);
    }
}
