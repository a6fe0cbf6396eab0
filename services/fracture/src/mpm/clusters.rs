//! PointClusters: points of one element that bonds join within it, and the clusters next to them.
//!
//! The points of an element see the same nodes. So whether the points of a node are connected is a
//! question about the clusters of its elements, a few dozen, in place of some hundred points with
//! seventeen bonds each, and every point's bonds are gone through once, not once for each of its 27
//! nodes.

use super::bonds::Bonds;
use super::grid::BackgroundGrid;
use crate::particles::Particles;

/// No cluster: a broken point, or one of an element that was not asked for.
pub(super) const NONE: u32 = u32::MAX;

/// The clusters of some elements.
#[derive(Debug)]
pub(super) struct PointClusters {
    /// Of each point by id.
    of: Vec<u32>,
    /// The first of each element that was asked for and the end of them; else [`NONE`].
    ranges: Vec<(u32, u32)>,
    /// First neighbour of each, then the number of neighbours.
    starts: Vec<u32>,
    /// PointClusters that a bond joins to each.
    next: Vec<u32>,
}

impl PointClusters {
    /// Ties the whole points of `elements`, each named once.
    pub(super) fn new(
        elements: &[u32],
        bonds: &Bonds,
        grid: &BackgroundGrid,
        particles: &Particles,
        slots: &[u32],
    ) -> Self {
        let mut clusters = Self {
            of: vec![NONE; particles.len()],
            ranges: vec![(NONE, NONE); grid.elements.len()],
            starts: vec![0],
            next: Vec::new(),
        };
        // Ends of the bonds that leave the element, by cluster, and where those of each begin.
        let (mut ends, mut firsts, mut points) = (Vec::new(), vec![0], Vec::new());
        for &e in elements {
            let first = firsts.len() as u32 - 1;
            let own = grid.elements[e as usize].points();
            for &start in &particles.id[own.clone()] {
                if clusters.of[start as usize] != NONE || !bonds.is_whole(start) {
                    continue;
                }
                let number = firsts.len() as u32 - 1;
                clusters.of[start as usize] = number;
                points.push(start);
                while let Some(point) = points.pop() {
                    for other in bonds.joined(point) {
                        if !own.contains(&(slots[other as usize] as usize)) {
                            ends.push(other);
                        } else if clusters.of[other as usize] == NONE {
                            clusters.of[other as usize] = number;
                            points.push(other);
                        }
                    }
                }
                firsts.push(ends.len());
            }
            clusters.ranges[e as usize] = (first, firsts.len() as u32 - 1);
        }
        let mut seen = vec![NONE; firsts.len()];
        for (number, bounds) in firsts.windows(2).enumerate() {
            for &other in &ends[bounds[0]..bounds[1]] {
                let to = clusters.of[other as usize];
                if to != NONE && seen[to as usize] != number as u32 {
                    seen[to as usize] = number as u32;
                    clusters.next.push(to);
                }
            }
            clusters.starts.push(clusters.next.len() as u32);
        }
        clusters
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Of a point.
    pub(super) fn of(&self, id: u32) -> u32 {
        self.of[id as usize]
    }

    /// Those of an element, in the order of their first points.
    pub(super) fn of_element(&self, element: u32) -> std::ops::Range<u32> {
        let (first, end) = self.ranges[element as usize];
        first..end
    }

    /// Those that bonds join to one.
    pub(super) fn next(&self, cluster: u32) -> &[u32] {
        let cluster = cluster as usize;
        &self.next[self.starts[cluster] as usize..self.starts[cluster + 1] as usize]
    }
}
