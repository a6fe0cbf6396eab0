//! The points near a node: where these are parted the node is, though a way leads round the tip of
//! the crack through points that are farther off.

use super::{AWAY, Marks, NONE, NodePart, OPEN, SplitSearch};
use crate::mpm::bonds::NEAR;
use crate::mpm::grid::AROUND;
use cullet_geometry::Vec3;

impl SplitSearch<'_> {
    /// Labels the connected sets of a node's near whole points; how many there are. With one or
    /// none no label is left.
    pub(super) fn near_sets(&self, node: u32, rows: &[u32], marks: &mut Marks) -> u32 {
        let place = Vec3::from(self.grid.nodes.place[node as usize].map(f64::from));
        let is_near = |id: u32| (self.bonds.place(id) - place).norm_squared() <= NEAR * NEAR;
        marks.near.clear();
        marks.near.extend(self.ids(rows).filter(|&id| self.bonds.is_whole(id) && is_near(id)));
        let mut sets = self.flood_near(false, marks);
        if sets > 1 {
            // What no crack has parted may hang together through points that are not near.
            let whole = std::mem::take(&mut marks.near);
            whole.iter().for_each(|&id| marks.points[id as usize] = AWAY);
            marks.near.extend(self.ids(rows).filter(|&id| is_near(id)));
            let parts = self.flood_near(true, marks);
            let label = |id: u32, marks: &Marks| marks.points[id as usize];
            let size = |part| marks.near.iter().filter(|&&id| label(id, marks) == part).count();
            let most = (0..parts).rev().max_by_key(|&part| size(part)).unwrap_or(0);
            let own: Vec<u32> = whole.into_iter().filter(|&id| label(id, marks) == most).collect();
            marks.near.iter().for_each(|&id| marks.points[id as usize] = AWAY);
            marks.near = own;
            sets = self.flood_near(false, marks);
        }
        if sets < 2 {
            marks.near.iter().for_each(|&id| marks.points[id as usize] = AWAY);
        }
        sets
    }

    /// Numbers the connected sets of the near points, by bonds that join or by all that there were.
    fn flood_near(&self, all: bool, marks: &mut Marks) -> u32 {
        marks.near.iter().for_each(|&id| marks.points[id as usize] = OPEN);
        let (mut sets, mut left) = (0, marks.near.len());
        for k in 0..marks.near.len() {
            let start = marks.near[k];
            if marks.points[start as usize] != OPEN {
                continue;
            }
            marks.points[start as usize] = sets;
            marks.stack.push(start);
            left -= 1;
            while let Some(id) = marks.stack.pop() {
                let mut visit = |other: u32| {
                    if marks.points[other as usize] == OPEN {
                        marks.points[other as usize] = sets;
                        marks.stack.push(other);
                        left -= 1;
                    }
                };
                match all {
                    true => self.bonds.others(id).for_each(&mut visit),
                    false => self.bonds.joined(id).for_each(&mut visit),
                }
            }
            sets += 1;
            if left == 0 {
                break;
            }
        }
        sets
    }

    /// The points of each of the sets that the near ones are in: others go with the set that is
    /// next along bonds, those that none reaches by themselves.
    pub(super) fn divide_near(&self, rows: &[u32], sets: u32, marks: &mut Marks) -> Vec<NodePart> {
        let mut whole: Vec<u32> = Vec::new();
        for id in self.ids(rows) {
            let label = &mut marks.points[id as usize];
            if self.clusters.of(id) == NONE {
                *label = OPEN;
                marks.broken.push(id);
            } else if *label == AWAY {
                *label = OPEN;
                whole.push(id);
            }
        }
        // Broken points are no way: they are given to sets at the end.
        let mut next = std::mem::take(&mut marks.near);
        let mut at = 0;
        while at < next.len() {
            let id = next[at];
            for other in self.bonds.joined(id) {
                if marks.points[other as usize] == OPEN {
                    marks.points[other as usize] = marks.points[id as usize];
                    next.push(other);
                }
            }
            at += 1;
        }
        marks.near = next;
        let mut count = sets;
        let mut known: Vec<(u32, u32)> = Vec::new();
        for id in whole {
            if marks.points[id as usize] != OPEN {
                continue;
            }
            let set = marks.clusters[self.clusters.of(id) as usize];
            let number = known.iter().find(|row| row.0 == set).map(|row| row.1);
            let number = number.unwrap_or_else(|| {
                known.push((set, count));
                count += 1;
                count - 1
            });
            marks.points[id as usize] = number;
        }
        self.gather(rows, count, marks)
    }

    /// The points that a node sees, by id.
    fn ids(&self, rows: &[u32]) -> impl Iterator<Item = u32> {
        let elements = rows.iter().map(|&row| &self.grid.elements[row as usize / AROUND]);
        elements.flat_map(|element| self.particles.id[element.points()].iter().copied())
    }
}
