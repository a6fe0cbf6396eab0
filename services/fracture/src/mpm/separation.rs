//! Which points a crack has parted, and at which nodes that parts the velocity field.
//!
//! Points are joined by bonds to their neighbours. A point that breaks is a small piece of crack:
//! a disc through it, across the direction of the pull that broke it. The disc cuts the bonds
//! between whole points that cross it; the point itself stays with the side where its whole
//! neighbours are. A node whose points are no longer connected among themselves becomes one node
//! for each connected set of them: so a crack that ends inside a node's reach parts nothing there,
//! and where three fragments meet there are three fields (F17, F19). What has parted stays parted
//! (F21).
//!
//! Connection is asked for among a node's own points, so that parts of a body that come close to
//! each other, and touch nowhere, are not welded by the grid either.

use super::grid::{AROUND, Element, Grid, Nodes, Rows};
use super::kernel::Stencil;
use crate::particles::Particles;
use cullet_geometry::Vec3;

/// Longest bond, in cells: about 17 neighbours where 8 points share a cell.
const BOND: f64 = 0.8;

/// Radius of a broken point's disc, in cells: discs of neighbours half a cell apart overlap.
const DISC: f64 = 0.5;

/// Bonds and how far cracks have cut them.
#[derive(Clone, Debug, Default)]
pub(super) struct Separation {
    /// Place of each point by id, in cells.
    places: Vec<Vec3>,
    /// One over the size of a cell by axis \[1/m\].
    scale: Vec3,
    /// First bond of each point by id, then the number of bonds.
    starts: Vec<u32>,
    /// The other end of each bond.
    others: Vec<u32>,
    /// Whether it holds.
    holds: Vec<bool>,
    /// By id: the unit direction to the side a broken point stays with \[1/cell\]; else zero.
    stays: Vec<Vec3>,
}

/// A set of connected points at a node.
#[derive(Default)]
struct Part {
    /// Points by place in the arrays, with the node's number among the 27 of their element.
    points: Vec<(u32, u32)>,
    mass: f64,
    /// Mass times the distance from the node, in cells.
    moment: Vec3,
}

impl Part {
    /// Adds up what the node carries of it.
    fn measure(&mut self, grid: &Grid, particles: &Particles) {
        for &(p, k) in &self.points {
            let stencil = Stencil::new(&particles.reference[p as usize], &grid.spacing);
            let [x, y, z] = [k / 9, k / 3 % 3, k % 3].map(|i| i as usize);
            let weight = stencil.weight[0][x] * stencil.weight[1][y] * stencil.weight[2][z];
            let mass = weight * particles.mass(p as usize);
            let away = Vec3::new(stencil.away[0][x], stencil.away[1][y], stencil.away[2][z]);
            self.mass += mass;
            self.moment -= away * mass;
        }
    }

    fn weigh(&self, nodes: &mut Nodes, node: u32) {
        nodes.mass[node as usize] = self.mass;
        nodes.lean[node as usize] = self.moment / self.mass;
    }
}

impl Separation {
    pub(super) fn new(particles: &Particles, spacing: &Vec3) -> Self {
        let n = particles.len();
        let scale = spacing.map(|h| 1.0 / h);
        let mut places = vec![Vec3::zeros(); n];
        for (x, &id) in particles.reference.iter().zip(&particles.id) {
            places[id as usize] = x.component_mul(&scale);
        }
        let cell = |x: &Vec3| [x.x, x.y, x.z].map(|c| libm::floor(c / BOND) as i32);
        let mut cells: Vec<([i32; 3], u32)> =
            places.iter().enumerate().map(|(id, x)| (cell(x), id as u32)).collect();
        cells.sort_unstable();
        let (mut starts, mut others) = (vec![0], Vec::new());
        for (id, x) in places.iter().enumerate() {
            let [i, j, k] = cell(x);
            for (a, b) in (i - 1..=i + 1).flat_map(|a| (j - 1..=j + 1).map(move |b| (a, b))) {
                let first = cells.partition_point(|(cell, _)| *cell < [a, b, k - 1]);
                let near = cells[first..].iter().take_while(|(cell, _)| *cell <= [a, b, k + 1]);
                let near = near.filter(|(_, other)| *other as usize != id);
                let bonded = near.filter(|(_, other)| {
                    (places[*other as usize] - x).norm_squared() < BOND * BOND
                });
                others.extend(bonded.map(|(_, other)| *other));
            }
            starts.push(others.len() as u32);
        }
        let holds = vec![true; others.len()];
        Self { places, scale, starts, others, holds, stays: vec![Vec3::zeros(); n] }
    }

    fn bonds(&self, id: u32) -> std::ops::Range<usize> {
        self.starts[id as usize] as usize..self.starts[id as usize + 1] as usize
    }

    fn cut(&mut self, a: u32, b: u32) {
        for (from, to) in [(a, b), (b, a)] {
            for bond in self.bonds(from) {
                if self.others[bond] == to {
                    self.holds[bond] = false;
                }
            }
        }
    }

    /// The connected set of each whole point by id, numbered by their first points; `None` for
    /// broken ones.
    pub(super) fn pieces(&self) -> Vec<Option<u32>> {
        let mut piece = vec![OPEN; self.places.len()];
        let (mut pieces, mut stack) = (0, Vec::new());
        for start in 0..self.places.len() as u32 {
            if piece[start as usize] == OPEN && self.is_whole(start) {
                self.flood(start, pieces, &mut piece, &mut stack);
                pieces += 1;
            }
        }
        piece.into_iter().map(|number| (number < OPEN).then_some(number)).collect()
    }

    /// Cuts the bonds for which `apart` holds, either way round, and parts all nodes that are not
    /// connected; whether there were any.
    pub(super) fn sever(
        &mut self,
        apart: impl Fn(&Vec3, &Vec3) -> bool,
        grid: &mut Grid,
        particles: &mut Particles,
        slots: &[u32],
    ) -> bool {
        for id in 0..self.places.len() as u32 {
            let place = |id: u32| &particles.reference[slots[id as usize] as usize];
            for bond in self.bonds(id) {
                let (a, b) = (place(id), place(self.others[bond]));
                self.holds[bond] &= !apart(a, b) && !apart(b, a);
            }
        }
        let nodes: Vec<u32> = (0..grid.nodes.len() as u32).collect();
        self.part(&nodes, grid, particles, slots)
    }

    /// Cuts what the `broken` points (by id) cut, and parts the nodes that this disconnects;
    /// whether it did.
    pub(super) fn grow(
        &mut self,
        broken: &[u32],
        grid: &mut Grid,
        particles: &mut Particles,
        slots: &[u32],
    ) -> bool {
        let is_broken = |id: u32| particles.damage[slots[id as usize] as usize] >= 1.0;
        for &id in broken {
            // In cells a plane's normal is the covector n·h.
            let normal = particles.normal[slots[id as usize] as usize].component_div(&self.scale);
            let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::x);
            let centre = self.places[id as usize];
            let whole = self.bonds(id).map(|bond| self.others[bond]).filter(|&o| !is_broken(o));
            let lean: f64 =
                whole.map(|other| normal.dot(&(self.places[other as usize] - centre))).sum();
            self.stays[id as usize] = if lean < 0.0 { -normal } else { normal };
        }
        let mut touched: Vec<u32> = Vec::new();
        for &id in broken {
            self.cut_around(id, &mut touched);
        }
        let mut touched: Vec<u32> = touched.iter().map(|&id| slots[id as usize]).collect();
        touched.sort_unstable();
        touched.dedup();
        let mut nodes: Vec<u32> = Vec::new();
        for p in touched {
            let after = grid.elements.partition_point(|e| e.first <= p);
            nodes.extend(grid.elements[after - 1].nodes);
        }
        nodes.sort_unstable();
        nodes.dedup();
        self.part(&nodes, grid, particles, slots)
    }

    /// Cuts the bonds of one broken point and those between whole points that cross its disc.
    fn cut_around(&mut self, id: u32, touched: &mut Vec<u32>) {
        let (centre, stays) = (self.places[id as usize], self.stays[id as usize]);
        for q in self.bonds(id) {
            let near = self.others[q];
            let side = stays.dot(&(self.places[near as usize] - centre));
            let apart = if self.is_whole(near) {
                side < 0.0
            } else {
                // Two of one layer hold together; those that stay with opposite sides do not.
                self.stays[near as usize].dot(&stays) < 0.0
            };
            if apart && self.holds[q] {
                self.cut(id, near);
                touched.extend([id, near]);
            }
            if !self.is_whole(near) {
                continue;
            }
            for r in self.bonds(near) {
                let far = self.others[r];
                let other = stays.dot(&(self.places[far as usize] - centre));
                if !self.holds[r] || !self.is_whole(far) || side * other >= 0.0 {
                    continue;
                }
                let (a, b) = (self.places[near as usize], self.places[far as usize]);
                let crossing = a + (b - a) * (side / (side - other));
                if (crossing - centre).norm_squared() < DISC * DISC {
                    self.cut(near, far);
                    touched.extend([near, far]);
                }
            }
        }
    }

    fn is_whole(&self, id: u32) -> bool {
        self.stays[id as usize] == Vec3::zeros()
    }

    /// Parts those of `nodes` whose points are not connected; whether there were any.
    fn part(
        &self,
        nodes: &[u32],
        grid: &mut Grid,
        particles: &mut Particles,
        slots: &[u32],
    ) -> bool {
        let mut marks = Marks::new(particles.len());
        // Point, number of the node among its 27, new node.
        let mut moves: Vec<(u32, u32, u32)> = Vec::new();
        for &node in nodes {
            let mut parts = self.parts(node, grid, particles, slots, &mut marks);
            if parts.len() < 2 {
                continue;
            }
            parts.iter_mut().for_each(|part| part.measure(grid, particles));
            // The heaviest keeps the node; the first of equal ones.
            let heaviest =
                (0..parts.len()).fold(0, |m, k| if parts[k].mass > parts[m].mass { k } else { m });
            let rest = parts.remove(heaviest);
            rest.weigh(&mut grid.nodes, node);
            for part in parts {
                let copy = grid.nodes.copy(node);
                part.weigh(&mut grid.nodes, copy);
                moves.extend(part.points.iter().map(|&(p, k)| (p, k, copy)));
            }
        }
        if moves.is_empty() {
            return false;
        }
        moves.sort_unstable();
        regroup(grid, particles, &moves);
        true
    }

    /// The connected sets of a node's whole points, in the order of their first points. Broken
    /// points join nothing: each goes with the set that it has most bonds with, or where it is
    /// surrounded by broken ones, with its neighbour.
    fn parts(
        &self,
        node: u32,
        grid: &Grid,
        particles: &Particles,
        slots: &[u32],
        marks: &mut Marks,
    ) -> Vec<Part> {
        marks.gather(node, grid, particles);
        let mut count = 0;
        for at in 0..marks.points.len() {
            let start = marks.points[at];
            if marks.part[start as usize] == OPEN && self.is_whole(start) {
                self.flood(start, count, &mut marks.part, &mut marks.stack);
                count += 1;
            }
        }
        let mut parts = Vec::new();
        if count > 1 {
            self.share_broken(marks);
            parts.resize_with(count as usize, Part::default);
            for &id in &marks.points {
                let part = &mut parts[marks.part[id as usize] as usize];
                part.points.push((slots[id as usize], marks.number[id as usize]));
            }
        }
        marks.clear();
        parts
    }

    /// Numbers the whole points connected to `start` among those that are open.
    fn flood(&self, start: u32, number: u32, part: &mut [u32], stack: &mut Vec<u32>) {
        part[start as usize] = number;
        stack.push(start);
        while let Some(id) = stack.pop() {
            for bond in self.bonds(id).filter(|&bond| self.holds[bond]) {
                let other = self.others[bond];
                if part[other as usize] == OPEN && self.is_whole(other) {
                    part[other as usize] = number;
                    stack.push(other);
                }
            }
        }
    }

    /// Gives the broken points of the node at hand to sets.
    fn share_broken(&self, marks: &mut Marks) {
        let mut left: Vec<u32> =
            marks.points.iter().copied().filter(|&id| marks.part[id as usize] == OPEN).collect();
        while !left.is_empty() {
            let found: Vec<(u32, u32)> = left
                .iter()
                .filter_map(|&id| Some((id, self.favourite(id, &marks.part)?)))
                .collect();
            if found.is_empty() {
                left.iter().for_each(|&id| marks.part[id as usize] = 0);
                return;
            }
            found.iter().for_each(|&(id, part)| marks.part[id as usize] = part);
            left.retain(|&id| marks.part[id as usize] == OPEN);
        }
    }

    /// The set that a point has most bonds with; those that hold count more.
    fn favourite(&self, id: u32, part: &[u32]) -> Option<u32> {
        let mut votes: Vec<(u32, u32)> = Vec::new();
        for bond in self.bonds(id) {
            let number = part[self.others[bond] as usize];
            if number < OPEN {
                let weight = if self.holds[bond] { 100 } else { 1 };
                match votes.iter_mut().find(|vote| vote.0 == number) {
                    Some(vote) => vote.1 += weight,
                    None => votes.push((number, weight)),
                }
            }
        }
        votes.into_iter().max_by_key(|&(number, votes)| (votes, OPEN - number)).map(|vote| vote.0)
    }
}

/// Belongs to no set of the node at hand.
const AWAY: u32 = u32::MAX;
/// Belongs to the node at hand, to no set yet.
const OPEN: u32 = u32::MAX - 1;

/// The points of the node at hand, by id.
struct Marks {
    points: Vec<u32>,
    part: Vec<u32>,
    number: Vec<u32>,
    stack: Vec<u32>,
}

impl Marks {
    fn new(points: usize) -> Self {
        Self {
            points: Vec::new(),
            part: vec![AWAY; points],
            number: vec![0; points],
            stack: Vec::new(),
        }
    }

    fn gather(&mut self, node: u32, grid: &Grid, particles: &Particles) {
        for &row in grid.rows.of(node as usize) {
            for p in grid.elements[row as usize / AROUND].points() {
                let id = particles.id[p];
                self.points.push(id);
                self.part[id as usize] = OPEN;
                self.number[id as usize] = row % AROUND as u32;
            }
        }
    }

    fn clear(&mut self) {
        for &id in &self.points {
            self.part[id as usize] = AWAY;
        }
        self.points.clear();
    }
}

/// Gives points their new nodes and makes elements of those that still see the same ones.
fn regroup(grid: &mut Grid, particles: &mut Particles, moves: &[(u32, u32, u32)]) {
    let mut order: Vec<u32> = Vec::with_capacity(particles.len());
    let mut elements: Vec<Element> = Vec::with_capacity(grid.elements.len());
    let mut moves = moves.iter().peekable();
    for element in &grid.elements {
        let end = element.first + element.count;
        if moves.peek().is_none_or(|next| next.0 >= end) {
            order.extend(element.first..end);
            elements.push(element.clone());
            continue;
        }
        let mut groups: Vec<([u32; AROUND], Vec<u32>)> = Vec::new();
        for p in element.first..end {
            let mut nodes = element.nodes;
            while let Some(&&(_, k, node)) = moves.peek().filter(|next| next.0 == p) {
                nodes[k as usize] = node;
                moves.next();
            }
            match groups.iter_mut().find(|group| group.0 == nodes) {
                Some(group) => group.1.push(p),
                None => groups.push((nodes, vec![p])),
            }
        }
        for (nodes, points) in groups {
            let (first, count) = (order.len() as u32, points.len() as u32);
            order.extend(points);
            elements.push(Element { nodes, first, count, cell: element.cell });
        }
    }
    particles.reorder(&order);
    grid.elements = elements;
    grid.rows = Rows::new(grid.elements.iter().flat_map(|e| e.nodes), grid.nodes.len());
}
