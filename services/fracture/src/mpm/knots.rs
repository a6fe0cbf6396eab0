//! Knots: points of one element that bonds join within it, and the knots next to them.
//!
//! The points of an element see the same nodes. So whether the points of a node are connected is a
//! question about the knots of its elements, a few dozen, in place of some hundred points with
//! seventeen bonds each, and every point's bonds are gone through once, not once for each of its 27
//! nodes.

use super::grid::Grid;
use super::separation::Separation;
use crate::particles::Particles;

/// No knot: a broken point, or one of an element that was not asked for.
pub(super) const NONE: u32 = u32::MAX;

/// The knots of some elements.
#[derive(Debug)]
pub(super) struct Knots {
    /// Of each point by id.
    of: Vec<u32>,
    /// The first of each element that was asked for and the end of them; else [`NONE`].
    ranges: Vec<(u32, u32)>,
    /// First neighbour of each, then the number of neighbours.
    starts: Vec<u32>,
    /// Knots that a bond joins to each.
    next: Vec<u32>,
}

impl Knots {
    /// Ties the whole points of `elements`, each named once.
    pub(super) fn new(
        elements: &[u32],
        separation: &Separation,
        grid: &Grid,
        particles: &Particles,
        slots: &[u32],
    ) -> Self {
        let mut knots = Self {
            of: vec![NONE; particles.len()],
            ranges: vec![(NONE, NONE); grid.elements.len()],
            starts: vec![0],
            next: Vec::new(),
        };
        // Ends of the bonds that leave the element, knot by knot, and where those of each begin.
        let (mut ends, mut firsts, mut points) = (Vec::new(), vec![0], Vec::new());
        for &e in elements {
            let first = firsts.len() as u32 - 1;
            let own = grid.elements[e as usize].points();
            for &start in &particles.id[own.clone()] {
                if knots.of[start as usize] != NONE || !separation.is_whole(start) {
                    continue;
                }
                let number = firsts.len() as u32 - 1;
                knots.of[start as usize] = number;
                points.push(start);
                while let Some(point) = points.pop() {
                    for other in separation.joined(point) {
                        if !own.contains(&(slots[other as usize] as usize)) {
                            ends.push(other);
                        } else if knots.of[other as usize] == NONE {
                            knots.of[other as usize] = number;
                            points.push(other);
                        }
                    }
                }
                firsts.push(ends.len());
            }
            knots.ranges[e as usize] = (first, firsts.len() as u32 - 1);
        }
        let mut seen = vec![NONE; firsts.len()];
        for (number, bounds) in firsts.windows(2).enumerate() {
            for &other in &ends[bounds[0]..bounds[1]] {
                let to = knots.of[other as usize];
                if to != NONE && seen[to as usize] != number as u32 {
                    seen[to as usize] = number as u32;
                    knots.next.push(to);
                }
            }
            knots.starts.push(knots.next.len() as u32);
        }
        knots
    }

    /// How many.
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
    pub(super) fn next(&self, knot: u32) -> &[u32] {
        let knot = knot as usize;
        &self.next[self.starts[knot] as usize..self.starts[knot + 1] as usize]
    }
}
