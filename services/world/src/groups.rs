//! Bodies that joints hold together, in an order in which neighbours are near each other.

use crate::elastic_frame::KeptFactor;
use crate::jointed::Jointed;
use std::collections::{BTreeMap, BTreeSet};

/// Bodies that move and that joints connect, and these joints.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointedGroup {
    /// Ordered so that joined bodies have near places [Cuthill, McKee 1969].
    pub(crate) bodies: Vec<u32>,
    /// In order.
    pub(crate) joints: Vec<u32>,
    /// For each body the first place that it is joined to, its own included.
    pub(crate) first: Vec<usize>,
    pub(crate) factor: KeptFactor,
}

impl JointedGroup {
    /// Place of a body.
    pub(crate) fn places(&self) -> BTreeMap<u32, usize> {
        self.bodies.iter().enumerate().map(|(place, &id)| (id, place)).collect()
    }
}

/// The groups that joints make of the bodies that `moves` says can move, by their lowest body.
pub(crate) fn find_groups(
    joints: &BTreeMap<u32, Jointed>,
    moves: impl Fn(u32) -> bool,
) -> Vec<JointedGroup> {
    let mut near: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    let mut of: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (&id, joint) in joints {
        let ends = [Some(joint.a), joint.b].map(|end| end.filter(|&body| moves(body)));
        if let Some(owner) = ends[0].or(ends[1]) {
            of.entry(owner).or_default().push(id);
        }
        for end in ends.into_iter().flatten() {
            near.entry(end).or_default();
        }
        if let [Some(a), Some(b)] = ends {
            near.entry(a).or_default().insert(b);
            near.entry(b).or_default().insert(a);
        }
    }
    let mut left: BTreeSet<u32> = near.keys().copied().collect();
    let mut groups = Vec::new();
    while let Some(&start) = left.first() {
        let whole = walk(&near, start);
        let far = whole.last().copied().unwrap_or(start);
        let mut bodies = walk(&near, far);
        bodies.reverse();
        bodies.iter().for_each(|id| {
            left.remove(id);
        });
        let mut own: Vec<u32> =
            bodies.iter().flat_map(|id| of.get(id).into_iter().flatten().copied()).collect();
        own.sort_unstable();
        let mut group = JointedGroup { bodies, joints: own, ..JointedGroup::default() };
        let places = group.places();
        let lowest = |(place, id): (usize, &u32)| {
            let others = near.get(id).into_iter().flatten().filter_map(|other| places.get(other));
            others.copied().min().unwrap_or(place).min(place)
        };
        group.first = group.bodies.iter().enumerate().map(lowest).collect();
        groups.push(group);
    }
    groups
}

/// All that can be reached from a body, the near ones first, those of few neighbours before others.
fn walk(near: &BTreeMap<u32, BTreeSet<u32>>, start: u32) -> Vec<u32> {
    let degree = |id: &u32| near.get(id).map_or(0, BTreeSet::len);
    let mut order = vec![start];
    let mut seen = BTreeSet::from([start]);
    let mut next = 0;
    while let Some(id) = order.get(next) {
        let mut fresh: Vec<u32> = near
            .get(id)
            .into_iter()
            .flatten()
            .copied()
            .filter(|other| seen.insert(*other))
            .collect();
        fresh.sort_by_key(|other| (degree(other), *other));
        order.extend(fresh);
        next += 1;
    }
    order
}
