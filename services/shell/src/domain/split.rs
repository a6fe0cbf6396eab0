//! Cracks part control points: as many copies of each as there are connected sets of points that it
//! has functions at.
//!
//! At a split every field is unchanged at every point: stress, velocity, mass, momentum and energy
//! are exact. Only bending needs a remedy: the stiffness over the mass of a copy that sees little
//! of a cell grows without bound (F84), so that a copy has at least a share of its original's mass,
//! taken from the copy that it was parted from (F85).

use super::state::ShellDomain;
use crate::kernel::CellSide;
use cullet_simd::{LANES, Real};
use std::collections::{BTreeMap, BTreeSet};

/// Least mass of a copy over that of the control point before any split \[1\].
const LEAST_MASS: f64 = 0.05;

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Gives control points that see little of the shell, for it is trimmed, the mass of a light
    /// copy, and those that see nothing of it some.
    pub(super) fn weigh_trimmed(&mut self) {
        let share = self.surface.share.clone();
        for point in (0..self.seats.len()).filter(|&p| share[p] < 1.0) {
            let (cell, table) = self.surface.at(point);
            let [a1, a2] =
                [0, 1].map(|d| self.surface.sum(cell, &table.derivatives[d], &self.surface.nodes));
            let missing = (1.0 - self.surface.share[point]) * table.weight * a1.cross(&a2).norm();
            let thickness = self.setup[0].thickness;
            let mass = missing * thickness * self.density;
            for (&node, share) in cell.nodes[..N].iter().zip(&table.value) {
                self.split.mass[node as usize] += mass * share;
            }
        }
        for (node, &area) in
            self.surface.missing.iter().enumerate().filter(|(_, area)| **area > 0.0)
        {
            let cell = self.split.cells[node][0] as usize;
            let thickness = self.setup[self.seats[cell * self.surface.points_per_cell()]].thickness;
            self.split.mass[node] += area * thickness * self.density;
        }
        for (mass, whole) in self.mass.iter_mut().zip(&self.split.mass) {
            *mass = mass.max(LEAST_MASS * whole);
        }
    }

    /// Splits made so far.
    #[must_use]
    pub fn splits(&self) -> u64 {
        self.split.count
    }

    /// Parts the control points around points that have broken, or died, since the last call.
    pub(super) fn part(&mut self, changed: &[u32]) {
        let each = self.surface.points_per_cell() as u32;
        let mut around: BTreeSet<u32> = BTreeSet::new();
        for &point in changed {
            let cells = self.surface.around(point as usize).iter().chain([&point]);
            for cell in cells.map(|&p| p / each) {
                around.extend(&self.surface.cells[cell as usize].nodes[..N]);
            }
        }
        let mut moves: BTreeMap<u32, [u32; N]> = BTreeMap::new();
        for &origin in &around {
            self.part_node(origin, &mut moves);
        }
        if !moves.is_empty() {
            self.move_points(moves);
        }
    }

    /// Kinetic energy of mass that was added to light copies so far \[J\].
    #[must_use]
    pub fn added_energy(&self) -> f64 {
        self.split.added
    }

    /// Gives the parts of one control point's points copies of their own.
    fn part_node(&mut self, origin: u32, moves: &mut BTreeMap<u32, [u32; N]>) {
        let each = self.surface.points_per_cell() as u32;
        let cells = &self.split.cells[origin as usize];
        let slot = |cell: u32| {
            let nodes = &self.surface.cells[cell as usize].nodes[..N];
            nodes.iter().position(|&node| node == origin).unwrap_or(0)
        };
        // Points by the copy that they have now.
        let mut by_copy: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &cell in cells {
            let k = slot(cell);
            for point in (cell * each..(cell + 1) * each).filter(|&p| self.is_on(p as usize)) {
                let nodes = moves.get(&point).copied();
                let nodes = nodes.unwrap_or(self.elements[self.element_of(point as usize)].nodes);
                by_copy.entry(nodes[k]).or_default().push(point);
            }
        }
        let own = |points: &[u32]| -> f64 {
            let mass = |&p: &u32| {
                let setup = &self.setup[self.seats[p as usize]];
                let (_, table) = self.surface.at(p as usize);
                let area = setup.surface.area * setup.thickness;
                area * self.density * table.value[slot(p / each)]
            };
            points.iter().map(mass).sum()
        };
        let mut made = Vec::new();
        for (copy, points) in by_copy {
            let mut parts = self.links.components(&self.surface, &points);
            if parts.len() < 2 {
                continue;
            }
            parts.sort_by(|a, b| own(b).total_cmp(&own(a)).then(a.cmp(b)));
            let masses: Vec<f64> = parts.iter().map(|part| own(part)).collect();
            made.extend(parts.into_iter().zip(masses).skip(1).map(|(part, m)| (copy, part, m)));
        }
        let slots: Vec<Vec<usize>> =
            made.iter().map(|(_, p, _)| p.iter().map(|&p| slot(p / each)).collect()).collect();
        for ((copy, part, mass), slots) in made.into_iter().zip(slots) {
            let new = self.copy_node(copy, mass);
            for (point, k) in part.into_iter().zip(slots) {
                let before = self.elements[self.element_of(point as usize)].nodes;
                moves.entry(point).or_insert(before)[k] = new;
            }
        }
    }

    /// A copy of a control point whose points weigh `own` \[kg\].
    fn copy_node(&mut self, node: u32, own: f64) -> u32 {
        let (n, new) = (node as usize, self.mass.len() as u32);
        let floor = LEAST_MASS * self.split.mass[self.origin[n] as usize];
        let whole = self.mass[n];
        let mass = own.max(floor);
        let left = (whole - mass).max(floor);
        // Where both need the floor there is not mass enough: what is added moves as they do.
        self.split.added += 0.5 * (mass + left - whole) * self.velocity[n].norm_squared();
        self.mass[n] = left;
        self.mass.push(mass);
        self.displacement.push(self.displacement[n]);
        self.velocity.push(self.velocity[n]);
        self.external.push(self.external[n] * 0.5);
        self.external[n] *= 0.5;
        self.origin.push(self.origin[n]);
        self.split.count += 1;
        new
    }

    /// Puts points into elements with their control points.
    fn move_points(&mut self, moves: BTreeMap<u32, [u32; N]>) {
        let each = self.surface.points_per_cell();
        let touched: BTreeSet<usize> = moves.keys().map(|&p| self.element_of(p as usize)).collect();
        let mut changed = BTreeSet::new();
        let before = self.elements.len();
        for e in touched {
            let live: Vec<usize> =
                (0..each).filter(|q| self.elements[e].live >> q & 1 == 1).collect();
            let nodes_of = |domain: &Self, q: usize| {
                let point = domain.point_at[e * each + q];
                moves.get(&point).copied().unwrap_or(domain.elements[e].nodes)
            };
            let mut groups: BTreeMap<[u32; N], Vec<usize>> = BTreeMap::new();
            for &q in &live {
                groups.entry(nodes_of(self, q)).or_default().push(q);
            }
            // The element stays with the group that has its control points, or the first.
            let stays = match groups.contains_key(&self.elements[e].nodes) {
                true => self.elements[e].nodes,
                false => *groups.keys().next().unwrap_or(&self.elements[e].nodes),
            };
            self.elements[e].nodes = stays;
            changed.insert(e);
            for (nodes, points) in groups.into_iter().filter(|(nodes, _)| *nodes != stays) {
                let to = self.take_place(self.elements[e].table);
                self.elements[to].nodes = nodes;
                changed.insert(to);
                for q in points {
                    self.move_point(e * each + q, to * each + q);
                }
            }
        }
        self.reconnect(&changed, before);
    }

    /// A place for an element of that table.
    fn take_place(&mut self, table: u32) -> usize {
        if let Some(place) = self.split.vacant.get_mut(&table).and_then(Vec::pop) {
            return place as usize;
        }
        let (first, each) = (self.elements.len(), self.surface.points_per_cell());
        self.elements.resize(first + LANES, CellSide::vacant(table));
        let like = (0..first).find(|&e| self.elements[e].table == table).unwrap_or(0);
        for _ in 0..LANES {
            for q in 0..each {
                self.setup.push(self.setup[like * each + q]);
                self.states.push(self.states[like * each + q].clone());
                self.point_at.push(u32::MAX);
            }
        }
        let rest = (first as u32 + 1..(first + LANES) as u32).rev().collect();
        self.split.vacant.insert(table, rest);
        first
    }

    fn move_point(&mut self, from: usize, to: usize) {
        let each = self.surface.points_per_cell();
        self.setup[to] = self.setup[from];
        self.states[to] = self.states[from].clone();
        let point = std::mem::replace(&mut self.point_at[from], u32::MAX);
        self.point_at[to] = point;
        self.seats[point as usize] = to;
        self.elements[from / each].live &= !(1 << (from % each));
        self.elements[to / each].live |= 1 << (to % each);
    }

    /// Tells the kernel which elements have changed, `before` being how many there were.
    fn reconnect(&mut self, changed: &BTreeSet<usize>, before: usize) {
        let each = self.surface.points_per_cell();
        self.kernel.connect(&self.elements, &self.setup, changed, before, self.mass.len());
        let first = crate::kernel::ShellKernel::<R, N>::block_start(before);
        let grown = if self.elements.len() > before { first..self.elements.len() } else { 0..0 };
        let seats = changed.iter().copied().chain(grown).flat_map(|e| e * each..(e + 1) * each);
        let seats: BTreeSet<usize> = seats.collect();
        for seat in seats {
            self.watch(seat);
        }
    }
}
