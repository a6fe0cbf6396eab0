//! Which points a crack has parted, and at which nodes that parts the velocity field.
//!
//! Points are joined by bonds to their neighbours. A point that breaks is a small piece of crack:
//! a disc through it, across the direction of the pull that broke it. The disc cuts the bonds
//! between whole points that cross it; the point itself stays with the side where its whole
//! neighbours are. A node whose points are no longer connected among themselves becomes one node
//! for each connected set of them: so a crack that ends inside a node's reach parts nothing there,
//! and where three fragments meet there are three fields (F17, F19). What has parted stays parted
//! (F21). Where a node's near points are no longer connected the node parts as well, though a way
//! leads round through points that are farther off.
//!
//! Connection is asked for among a node's own points, so that parts of a body that come close to
//! each other, and touch nowhere, are not welded by the grid either.

use super::grid::BackgroundGrid;
use crate::particles::Particles;
use cullet_geometry::Vec3;

/// Longest bond, in cells: about 17 neighbours where 8 points share a cell.
const BOND: f64 = 0.8;

/// Radius of a broken point's disc, in cells: discs of neighbours half a cell apart overlap.
const DISC: f64 = 0.5;

/// How far from a node its near points are, in cells: it parts where these do not hang together.
pub(super) const NEAR: f64 = 1.0;

/// In no piece yet.
const OPEN: u32 = u32::MAX;

/// Bonds and how far cracks have cut them.
#[derive(Clone, Debug, Default)]
pub(super) struct Bonds {
    /// Place of each point by id, in cells.
    places: Vec<Vec3>,
    /// One over the size of a cell by axis \[1/m\].
    scale: Vec3,
    /// First bond of each point by id, then the number of bonds.
    starts: Vec<u32>,
    /// The bonds.
    bonds: Vec<Bond>,
    /// By id: the unit direction to the side a broken point stays with \[1/cell\]; else zero.
    stays: Vec<Vec3>,
}

/// The far end of a bond, by id, and what is left of it.
#[derive(Clone, Copy, Debug)]
struct Bond(u32);

impl Bond {
    const CUT: u32 = 1 << 31;
    const LOOSE: u32 = 1 << 30;

    fn other(self) -> u32 {
        self.0 & !(Self::CUT | Self::LOOSE)
    }

    /// No crack has cut it.
    fn holds(self) -> bool {
        self.0 & Self::CUT == 0
    }

    /// It holds, between whole points.
    fn joins(self) -> bool {
        self.0 & (Self::CUT | Self::LOOSE) == 0
    }
}

impl Bonds {
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
        let (mut starts, mut bonds) = (vec![0], Vec::new());
        for (id, x) in places.iter().enumerate() {
            let [i, j, k] = cell(x);
            for (a, b) in (i - 1..=i + 1).flat_map(|a| (j - 1..=j + 1).map(move |b| (a, b))) {
                let first = cells.partition_point(|(cell, _)| *cell < [a, b, k - 1]);
                let near = cells[first..].iter().take_while(|(cell, _)| *cell <= [a, b, k + 1]);
                let near = near.filter(|(_, other)| *other as usize != id);
                let bonded = near.filter(|(_, other)| {
                    (places[*other as usize] - x).norm_squared() < BOND * BOND
                });
                bonds.extend(bonded.map(|(_, other)| Bond(*other)));
            }
            starts.push(bonds.len() as u32);
        }
        Self { places, scale, starts, bonds, stays: vec![Vec3::zeros(); n] }
    }

    fn range(&self, id: u32) -> std::ops::Range<usize> {
        self.starts[id as usize] as usize..self.starts[id as usize + 1] as usize
    }

    fn bonds(&self, id: u32) -> impl Iterator<Item = Bond> {
        self.bonds[self.range(id)].iter().copied()
    }

    /// The other ends of the bonds of a whole point that hold, where those are whole too.
    pub(super) fn joined(&self, id: u32) -> impl Iterator<Item = u32> {
        self.bonds(id).filter(|bond| bond.joins()).map(Bond::other)
    }

    fn cut(&mut self, a: u32, b: u32) {
        self.mark(a, b, Bond::CUT);
        self.mark(b, a, Bond::CUT);
    }

    fn mark(&mut self, from: u32, to: u32, what: u32) {
        let range = self.range(from);
        if let Some(bond) = self.bonds[range].iter_mut().find(|bond| bond.other() == to) {
            bond.0 |= what;
        }
    }

    /// Notes at both ends of its bonds that a point is broken.
    fn loosen(&mut self, id: u32) {
        for at in self.range(id) {
            self.bonds[at].0 |= Bond::LOOSE;
            self.mark(self.bonds[at].other(), id, Bond::LOOSE);
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

    /// Cuts the bonds for which `apart` holds, either way round.
    pub(super) fn sever(
        &mut self,
        apart: impl Fn(&Vec3, &Vec3) -> bool,
        particles: &Particles,
        slots: &[u32],
    ) {
        for id in 0..self.places.len() as u32 {
            let place = |id: u32| &particles.reference[slots[id as usize] as usize];
            for at in self.range(id) {
                let (a, b) = (place(id), place(self.bonds[at].other()));
                if apart(a, b) || apart(b, a) {
                    self.bonds[at].0 |= Bond::CUT;
                }
            }
        }
    }

    /// Cuts what the `broken` points (by id) cut; the nodes that this may disconnect, ascending,
    /// and whether what it cuts is near them.
    pub(super) fn grow(
        &mut self,
        broken: &[u32],
        grid: &BackgroundGrid,
        particles: &Particles,
        slots: &[u32],
    ) -> Vec<(u32, bool)> {
        let is_broken = |id: u32| particles.damage[slots[id as usize] as usize] >= 1.0;
        for &id in broken {
            // In cells a plane's normal is the covector n·h.
            let normal = particles.normal[slots[id as usize] as usize].component_div(&self.scale);
            let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::x);
            let centre = self.places[id as usize];
            let whole = self.bonds(id).map(Bond::other).filter(|&other| !is_broken(other));
            let side: f64 =
                whole.map(|other| normal.dot(&(self.places[other as usize] - centre))).sum();
            self.stays[id as usize] = if side < 0.0 { -normal } else { normal };
        }
        broken.iter().for_each(|&id| self.loosen(id));
        let mut touched: Vec<u32> = Vec::new();
        for &id in broken {
            self.cut_around(id, &mut touched);
        }
        touched.sort_unstable();
        touched.dedup();
        let mut nodes: Vec<(u32, bool)> = Vec::new();
        for id in touched {
            let p = slots[id as usize];
            let after = grid.elements.partition_point(|e| e.first <= p);
            let x = self.place(id);
            nodes.extend(grid.elements[after - 1].nodes.map(|node| {
                let place = Vec3::from(grid.nodes.place[node as usize].map(f64::from));
                (node, (x - place).norm_squared() <= NEAR * NEAR)
            }));
        }
        // What is near comes first of each.
        nodes.sort_unstable_by_key(|&(node, near)| (node, !near));
        nodes.dedup_by_key(|node| node.0);
        nodes
    }

    /// Place of a point, in cells.
    pub(super) fn place(&self, id: u32) -> Vec3 {
        self.places[id as usize]
    }

    /// Cuts the bonds of one broken point and those between whole points that cross its disc.
    fn cut_around(&mut self, id: u32, touched: &mut Vec<u32>) {
        let (centre, stays) = (self.places[id as usize], self.stays[id as usize]);
        for q in self.range(id) {
            let near = self.bonds[q].other();
            let side = stays.dot(&(self.places[near as usize] - centre));
            let apart = if self.is_whole(near) {
                side < 0.0
            } else {
                // Two of one layer hold together; those that stay with opposite sides do not.
                self.stays[near as usize].dot(&stays) < 0.0
            };
            if apart && self.bonds[q].holds() {
                self.cut(id, near);
                touched.extend([id, near]);
            }
            if !self.is_whole(near) {
                continue;
            }
            for r in self.range(near) {
                let far = self.bonds[r].other();
                if !self.bonds[r].joins() {
                    continue;
                }
                let other = stays.dot(&(self.places[far as usize] - centre));
                if side * other >= 0.0 {
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

    pub(super) fn is_whole(&self, id: u32) -> bool {
        self.stays[id as usize] == Vec3::zeros()
    }

    /// Numbers the whole points connected to `start` that are open.
    fn flood(&self, start: u32, number: u32, part: &mut [u32], stack: &mut Vec<u32>) {
        part[start as usize] = number;
        stack.push(start);
        while let Some(id) = stack.pop() {
            for other in self.joined(id) {
                if part[other as usize] == OPEN {
                    part[other as usize] = number;
                    stack.push(other);
                }
            }
        }
    }

    /// The other ends of the bonds of a point, whatever is left of them.
    pub(super) fn others(&self, id: u32) -> impl Iterator<Item = u32> {
        self.bonds(id).map(Bond::other)
    }

    /// Likewise, and what each counts where a broken point joins a set: more where the bond holds.
    pub(super) fn votes(&self, id: u32) -> impl Iterator<Item = (u32, u32)> {
        self.bonds(id).map(|bond| (bond.other(), if bond.holds() { 100 } else { 1 }))
    }
}
