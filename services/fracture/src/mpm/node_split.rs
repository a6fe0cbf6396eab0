//! Splits nodes whose points are no longer connected, or whose near ones are not, and makes
//! elements of points that still see the same nodes.
//!
//! A node sees points up to 1.5 cells away. Were it parted only once all of these are, a crack
//! would pull on what it has passed for a cell more: the way round its tip is then still within the
//! node's reach.

mod near;

use super::bonds::Bonds;
use super::clusters::{NONE, PointClusters};
use super::grid::{AROUND, BackgroundGrid, GridElement, Nodes};
use super::stencil::share;
use crate::particles::Particles;
use cullet_geometry::Vec3;
use cullet_simd::Incidence;
use rayon::prelude::*;

/// Nodes of a piece of work.
const CHUNK: usize = 256;

/// What the split has changed.
#[derive(Debug, Default)]
pub(super) struct SplitChanges {
    /// First points of the elements that see other nodes now, ascending.
    pub(super) elements: Vec<u32>,
    /// Places of the points that are elsewhere in the arrays now.
    pub(super) moved: Vec<u32>,
}

/// A node that takes the place of another.
struct Move {
    /// The point that sees it.
    point: u32,
    /// Its number among the 27 of the point's element.
    number: u32,
    node: u32,
}

/// A set of connected points at a node.
#[derive(Default)]
struct NodePart {
    /// Points by place in the arrays, with the node's number among the 27 of their element.
    points: Vec<(u32, u32)>,
    mass: f64,
    /// Mass times the distance from the node, in cells.
    moment: Vec3,
}

impl NodePart {
    /// Adds up what the node carries of it.
    fn measure(&mut self, grid: &BackgroundGrid, particles: &Particles) {
        for &(p, k) in &self.points {
            let (weight, away) = share(&particles.reference[p as usize], &grid.spacing, k as usize);
            let mass = weight * particles.mass(p as usize);
            self.mass += mass;
            self.moment -= away * mass;
        }
    }

    fn weigh(&self, nodes: &mut Nodes, node: u32) {
        nodes.mass[node as usize] = self.mass;
        nodes.points_offset[node as usize] = self.moment / self.mass;
    }
}

/// Splits those of `nodes`, each named once, whose points are not connected; of those that are
/// marked also where the near ones are not.
pub(super) fn split(
    bonds: &Bonds,
    nodes: &[(u32, bool)],
    grid: &mut BackgroundGrid,
    particles: &mut Particles,
    slots: &[u32],
) -> SplitChanges {
    let rows = grid.rows_of(nodes.iter().map(|node| node.0));
    let mut asked = vec![false; grid.elements.len()];
    rows.entries.iter().for_each(|&row| asked[row as usize / AROUND] = true);
    let elements: Vec<u32> = (0..asked.len() as u32).filter(|&e| asked[e as usize]).collect();
    let clusters = PointClusters::new(&elements, bonds, grid, particles, slots);
    let search = SplitSearch { bonds, clusters: &clusters, rows: &rows, grid, particles };
    let found: Vec<(u32, Vec<NodePart>)> = nodes
        .par_chunks(CHUNK)
        .map_init(
            || Marks::new(particles.len(), clusters.len()),
            |marks, nodes| -> Vec<(u32, Vec<NodePart>)> {
                let parts =
                    nodes.iter().map(|&(node, near)| (node, search.parts(node, near, marks)));
                parts.filter(|(_, parts)| parts.len() > 1).collect()
            },
        )
        .flatten_iter()
        .collect();
    let mut moves = Vec::new();
    for (node, mut parts) in found {
        // The heaviest keeps the node; the first of equal ones.
        let heaviest =
            (0..parts.len()).fold(0, |m, k| if parts[k].mass > parts[m].mass { k } else { m });
        let rest = parts.remove(heaviest);
        rest.weigh(&mut grid.nodes, node);
        for part in parts {
            let copy = grid.nodes.copy(node);
            part.weigh(&mut grid.nodes, copy);
            let own = part.points.iter();
            moves.extend(own.map(|&(point, number)| Move { point, number, node: copy }));
        }
    }
    regroup(grid, particles, &moves)
}

/// What the search for a node's parts goes by.
struct SplitSearch<'a> {
    bonds: &'a Bonds,
    clusters: &'a PointClusters,
    rows: &'a Incidence,
    grid: &'a BackgroundGrid,
    particles: &'a Particles,
}

impl SplitSearch<'_> {
    /// The connected sets of a node's whole points, in the order of their first points; none where
    /// there are not several. Broken points join nothing: each goes with the set that it has most
    /// bonds with, or where it is surrounded by broken ones, with its neighbour.
    fn parts(&self, node: u32, near: bool, marks: &mut Marks) -> Vec<NodePart> {
        let rows = self.rows.of(node as usize);
        for &row in rows {
            for cluster in self.clusters.of_element(row / AROUND as u32) {
                marks.clusters[cluster as usize] = OPEN;
                marks.own.push(cluster);
            }
        }
        let (mut count, mut at, mut open) = (0, 0, marks.own.len());
        while open > 0 {
            let start = marks.own[at];
            if marks.clusters[start as usize] == OPEN {
                open -= self.flood(start, count, open, marks);
                count += 1;
            }
            at += 1;
        }
        let parted = if near { self.near_sets(node, rows, marks) } else { 0 };
        let parts = match parted {
            0 | 1 if count > 1 => self.divide(rows, count, marks),
            0 | 1 => Vec::new(),
            sets => self.divide_near(rows, sets, marks),
        };
        for cluster in marks.own.drain(..) {
            marks.clusters[cluster as usize] = AWAY;
        }
        parts
    }

    /// Numbers the clusters connected to `start` among those that are open; how many. No more than
    /// `most` are.
    fn flood(&self, start: u32, number: u32, most: usize, marks: &mut Marks) -> usize {
        marks.clusters[start as usize] = number;
        marks.stack.push(start);
        let mut found = 1;
        while let Some(cluster) = marks.stack.pop() {
            if found == most {
                marks.stack.clear();
                break;
            }
            for &other in self.clusters.next(cluster) {
                if marks.clusters[other as usize] == OPEN {
                    marks.clusters[other as usize] = number;
                    marks.stack.push(other);
                    found += 1;
                }
            }
        }
        found
    }

    /// The points of each of `count` sets.
    fn divide(&self, rows: &[u32], count: u32, marks: &mut Marks) -> Vec<NodePart> {
        let elements = rows.iter().map(|&row| &self.grid.elements[row as usize / AROUND]);
        for &id in elements.flat_map(|element| &self.particles.id[element.points()]) {
            let cluster = self.clusters.of(id);
            if cluster == NONE {
                marks.points[id as usize] = OPEN;
                marks.broken.push(id);
            } else {
                marks.points[id as usize] = marks.clusters[cluster as usize];
            }
        }
        self.gather(rows, count, marks)
    }

    /// What each of `count` sets has, by the labels of its whole points.
    fn gather(&self, rows: &[u32], count: u32, marks: &mut Marks) -> Vec<NodePart> {
        self.share_broken(count, marks);
        marks.broken.clear();
        let mut parts: Vec<NodePart> = (0..count).map(|_| NodePart::default()).collect();
        for &row in rows {
            for p in self.grid.elements[row as usize / AROUND].points() {
                let label = &mut marks.points[self.particles.id[p] as usize];
                parts[*label as usize].points.push((p as u32, row % AROUND as u32));
                *label = AWAY;
            }
        }
        parts.iter_mut().for_each(|part| part.measure(self.grid, self.particles));
        parts
    }

    /// Gives the broken points of the node at hand to sets: first those that have bonds with one,
    /// then those that have bonds with these, and so on.
    fn share_broken(&self, count: u32, marks: &mut Marks) {
        let mut votes = vec![0; count as usize];
        let mut asked = marks.broken.clone();
        while !asked.is_empty() {
            let mut found: Vec<(u32, u32)> = Vec::new();
            for &id in &asked {
                if let Some(label) = self.favourite(id, marks, &mut votes) {
                    found.push((id, label));
                }
            }
            for &(id, label) in &found {
                marks.points[id as usize] = label;
            }
            asked.clear();
            for &(id, _) in &found {
                for other in self.bonds.others(id) {
                    if marks.points[other as usize] == OPEN {
                        marks.points[other as usize] = ASKED;
                        asked.push(other);
                    }
                }
            }
            asked.iter().for_each(|&id| marks.points[id as usize] = OPEN);
        }
        for &id in &marks.broken {
            let label = &mut marks.points[id as usize];
            *label = if *label == OPEN { 0 } else { *label };
        }
    }

    /// The set that a broken point has most bonds with, the first of equal ones.
    fn favourite(&self, id: u32, marks: &Marks, votes: &mut [u32]) -> Option<u32> {
        votes.fill(0);
        for (other, weight) in self.bonds.votes(id) {
            if let Some(votes) = votes.get_mut(marks.points[other as usize] as usize) {
                *votes += weight;
            }
        }
        let best = (0..votes.len()).rev().max_by_key(|&label| votes[label])?;
        (votes[best] > 0).then_some(best as u32)
    }
}

/// Belongs to no set of the node at hand.
const AWAY: u32 = u32::MAX;
/// Belongs to the node at hand, to no set yet.
const OPEN: u32 = u32::MAX - 1;
/// Likewise, and is asked for.
const ASKED: u32 = u32::MAX - 2;

/// The clusters and the points of the node at hand.
struct Marks {
    own: Vec<u32>,
    /// Set of each cluster.
    clusters: Vec<u32>,
    /// Set of each point by id.
    points: Vec<u32>,
    /// The node's broken points by id.
    broken: Vec<u32>,
    /// The node's near points by id.
    near: Vec<u32>,
    stack: Vec<u32>,
}

impl Marks {
    fn new(points: usize, clusters: usize) -> Self {
        Self {
            own: Vec::new(),
            clusters: vec![AWAY; clusters],
            points: vec![AWAY; points],
            broken: Vec::new(),
            near: Vec::new(),
            stack: Vec::new(),
        }
    }
}

/// Gives points their new nodes and makes elements of those that still see the same ones.
fn regroup(grid: &mut BackgroundGrid, particles: &mut Particles, moves: &[Move]) -> SplitChanges {
    let mut changes = SplitChanges::default();
    if moves.is_empty() {
        return changes;
    }
    let rows = Incidence::new(moves.iter().map(|m| m.point), particles.len());
    let mut elements: Vec<GridElement> = Vec::with_capacity(grid.elements.len() + moves.len() / 8);
    let mut olds: Vec<u32> = Vec::new();
    // The groups of an element's points, and that of each point.
    let (mut groups, mut own): (Vec<[u32; AROUND]>, Vec<usize>) = (Vec::new(), Vec::new());
    for element in &grid.elements {
        let (first, end) = (element.first, element.first + element.count);
        if rows.starts[first as usize] == rows.starts[end as usize] {
            elements.push(element.clone());
            continue;
        }
        groups.clear();
        own.clear();
        for p in element.points() {
            let mut nodes = element.nodes;
            for &m in rows.of(p) {
                nodes[moves[m as usize].number as usize] = moves[m as usize].node;
            }
            let known = groups.iter().position(|group| *group == nodes);
            own.push(known.unwrap_or(groups.len()));
            if known.is_none() {
                groups.push(nodes);
            }
        }
        changes.elements.push(first);
        let mut next = first;
        for (g, &nodes) in groups.iter().enumerate() {
            let start = next;
            for (p, _) in (first..end).zip(&own).filter(|(_, group)| **group == g) {
                if p != next {
                    changes.moved.push(next);
                    olds.push(p);
                }
                next += 1;
            }
            elements.push(GridElement {
                nodes,
                first: start,
                count: next - start,
                cell: element.cell,
            });
        }
    }
    particles.shift(&olds, &changes.moved);
    grid.elements = elements;
    changes
}

#[cfg(test)]
mod tests;
