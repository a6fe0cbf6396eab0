//! The nodes of a lattice in and around a body, and the labels of the material there.

use super::damage::NodeDamage;
use super::lattice::{Lattice, LatticeChoice, NODE, weights};
use super::odds::{NONE, OddsTable, ZONE};
use super::sampled::SampledPieces;
use crate::error::CutError;
use crate::field::DamageField;
use crate::pieces::Pieces;
use cullet_geometry::inside::Inside;
use cullet_geometry::mesh::bounds;
use cullet_geometry::{TriMesh, Vec3};
use std::collections::BTreeMap;

/// A node is damaged from this share of broken weight on. With quadratic weights a band one spacing
/// thick gives its worst-placed node 0.479: all such bands are seen, and unbroken bridges of more
/// than 1.3 spacings (where the broken share falls below 0.4 wherever they lie) still hold.
pub(super) const DAMAGED: f64 = 0.4;
/// Share of its particles, by weight, that gives a node their piece.
const HALF: f64 = 0.5;
/// Share of its particles in no piece up to which a node takes the piece that holds most of them,
/// be that half or not: three small pieces may meet there, but no crack's band.
const FEW: f64 = 0.1;
/// Distance of lattice nodes over the spacing where the pieces are known point by point: small ones
/// keep their shape, and faces lean less to the axes (F22). Points are half a spacing apart.
const FINER: f64 = 0.7;
/// ... and where some were sampled, which are smaller still, unless their coarseness is above 1.
const FINEST: f64 = 0.5;
/// Most lattice nodes; beyond, memory (some 100 bytes each) would exceed a worker's share.
const MAX_NODES: f64 = 5e7;
/// The lattice reaches this many nodes beyond the body on every side.
const MARGIN: f64 = 2.0;
/// ... and begins at a place that faces of bodies and their halves and quarters keep clear of, or
/// corners of cracks would lie in them (F25).
const OFFSET: [f64; 3] = [2.0371, 2.0813, 2.1237];

/// What the lattice nodes know of material and damage.
#[derive(Debug)]
pub(crate) struct LatticeNodes {
    pub(super) lattice: Lattice,
    /// Bit 3: inside the body. Bits 0, 1, 2: so is the middle of the edge to the next node along
    /// x, y, z.
    inside: Vec<u8>,
    pub(super) damage: NodeDamage,
    /// Component of undamaged material nodes, or `NONE`.
    pub(super) label: Vec<u32>,
    pub(super) labels: u32,
    /// The label of every node, once they are filled.
    pub(super) reach: Vec<u32>,
    pub(super) odds: OddsTable,
    pub(super) sampled: SampledPieces,
    /// Length over which damage is looked at \[m\]: no less than the distance of nodes.
    pub(super) unit: f64,
}

impl LatticeNodes {
    /// Spreads the field to the nodes in and around `body` and labels the undamaged ones inside.
    pub(crate) fn new(
        body: &TriMesh,
        field: &DamageField<'_>,
        choice: &LatticeChoice,
    ) -> Result<Self, CutError> {
        check(field)?;
        let drawn = field.pieces.filter(|pieces| !pieces.rubble.balls.is_empty());
        let unit = if field.pieces.is_some() { FINER * field.spacing } else { field.spacing };
        let h = drawn.map_or(unit, |pieces| FINEST * pieces.tolerance.coarseness() * field.spacing);
        let unit = unit.max(h);
        let h = h * choice.refinement;
        let along = |p: &Vec3| choice.axes.tr_mul(p);
        let places = body.vertices.iter().chain(field.positions).map(along);
        let reach = bounds(&places.collect::<Vec<Vec3>>()).unwrap_or_default();
        let low = reach.0 - Vec3::from(OFFSET) * h;
        let steps = (reach.1 - low) / h + Vec3::repeat(MARGIN + 1.0);
        let count = steps.x * steps.y * steps.z;
        if count > MAX_NODES {
            return Err(CutError::TooLarge {
                what: "lattice nodes",
                value: count,
                limit: MAX_NODES,
            });
        }
        let dims = [0, 1, 2].map(|k| steps[k].ceil() as usize);
        let lattice = Lattice { low: choice.axes * low, spacing: h, dims, axes: choice.axes };
        let rubble = field.pieces.map(|pieces| pieces.rubble.clone()).unwrap_or_default();
        let mut nodes = Self {
            inside: lattice.inside(&Inside::new(body)),
            damage: NodeDamage::spread(&lattice, field),
            label: vec![NONE; lattice.len()],
            labels: 0,
            reach: Vec::new(),
            odds: OddsTable::new(lattice.len()),
            sampled: SampledPieces::new(lattice.len(), rubble, field.spacing),
            unit,
            lattice,
        };
        nodes.look_around();
        match field.pieces {
            Some(pieces) => nodes.take_labels(field.positions, pieces),
            None if (0..lattice.len()).any(|i| nodes.is_damaged(i)) => nodes.fill_labels(),
            None => {}
        }
        Ok(nodes)
    }

    /// Gives each node inside the body the piece that holds most of its particles by weight, where
    /// that is at least half of them or nearly all are in some piece; sampled pieces count as one,
    /// and the node goes to the nearest of them. Labels are numbered by their first nodes.
    fn take_labels(&mut self, positions: &[Vec3], pieces: &Pieces) {
        let mut shares: Vec<Vec<(Option<u32>, f64)>> = vec![Vec::new(); self.lattice.len()];
        for (&p, &piece) in positions.iter().zip(&pieces.of) {
            let (base, w) = weights(self.lattice.steps_to(p));
            for k in 0..27 {
                let [x, y, z] = [k % 3, k / 3 % 3, k / 9];
                let node = self.lattice.index([base[0] + x, base[1] + y, base[2] + z]);
                let share = w[0][x] * w[1][y] * w[2][z];
                match shares[node].iter_mut().find(|entry| entry.0 == piece) {
                    Some(entry) => entry.1 += share,
                    None => shares[node].push((piece, share)),
                }
            }
        }
        let mut names = BTreeMap::new();
        let mut shared = Vec::new();
        for (i, shares) in shares.iter().enumerate().filter(|&(i, _)| self.inside[i] & NODE != 0) {
            let all: f64 = shares.iter().map(|entry| entry.1).sum();
            let free: f64 = shares.iter().filter(|entry| entry.0.is_none()).map(|e| e.1).sum();
            let least = if free <= FEW * all { 0.0 } else { HALF * all };
            let Some((found, _)) = most(pieces, shares).filter(|entry| entry.1 >= least) else {
                continue;
            };
            let piece = found.unwrap_or_else(|| {
                let of = shares.iter().filter_map(|entry| pieces.drawn(entry.0?));
                let place = self.lattice.place(self.lattice.node(i));
                self.sampled.ball[i] =
                    self.sampled.rubble.nearest(of, &(place / self.sampled.cell)).unwrap_or(NONE);
                pieces.found + self.sampled.ball[i]
            });
            let next = names.len() as u32;
            self.label[i] = *names.entry(piece).or_insert(next);
            if free <= FEW * all {
                shared.push(i);
            }
        }
        self.labels = names.len() as u32;
        self.sampled.label = vec![NONE; self.sampled.rubble.balls.len()];
        self.sampled.whole = vec![false; names.len()];
        for (&piece, &label) in &names {
            if let Some(ball) = pieces.drawn(piece) {
                self.sampled.label[ball as usize] = label;
                self.sampled.whole[label as usize] = true;
            }
        }
        for i in shared {
            let own = shares[i].iter().filter_map(|&(piece, share)| {
                let name = match pieces.drawn(piece?) {
                    Some(_) => ZONE,
                    None => *names.get(&piece?)?,
                };
                Some((name, share))
            });
            self.odds.expect(i, own);
        }
    }

    pub(super) fn is_inside(&self, i: usize) -> bool {
        self.inside[i] & NODE != 0
    }

    pub(super) fn is_damaged(&self, i: usize) -> bool {
        self.is_inside(i) && self.damage.broken[i] >= DAMAGED
    }

    fn fill_labels(&mut self) {
        for start in 0..self.lattice.len() {
            if self.label[start] != NONE || !self.is_sound(start) {
                continue;
            }
            self.label[start] = self.labels;
            let mut stack = vec![start];
            while let Some(i) = stack.pop() {
                for j in self.lattice.beside(i) {
                    if self.label[j] == NONE && self.is_sound(j) && self.connects(i, j) {
                        self.label[j] = self.labels;
                        stack.push(j);
                    }
                }
            }
            self.labels += 1;
        }
    }

    /// Whether the edge between two neighbours runs through the body.
    pub(super) fn connects(&self, i: usize, j: usize) -> bool {
        let (from, step) = (i.min(j), i.abs_diff(j));
        let axis = if step == 1 { 0 } else { 1 + usize::from(step != self.lattice.dims[0]) };
        self.inside[from] & (1 << axis) != 0
    }

    pub(super) fn is_sound(&self, i: usize) -> bool {
        self.is_inside(i) && self.damage.broken[i] < DAMAGED
    }

    /// How many components of undamaged nodes there are.
    pub(crate) fn labels(&self) -> u32 {
        self.labels
    }

    /// Whether there is damage, and nothing else.
    pub(crate) fn is_crushed(&self) -> bool {
        let mut inside = (0..self.lattice.len()).filter(|&i| self.is_inside(i)).peekable();
        inside.peek().is_some() && inside.all(|i| self.is_damaged(i))
    }

    /// The label of the node nearest to a point.
    pub(crate) fn label_at(&self, point: Vec3) -> u32 {
        self.reach[self.lattice.nearest(point)]
    }

    /// The nodes along an axis that a number of units reaches.
    pub(super) fn steps(&self, units: f64) -> usize {
        (units * self.unit / self.lattice.spacing).ceil() as usize
    }

    /// Whether a damaged node lies within two units of the point, along every axis: a crack
    /// elsewhere is an artefact (F27).
    pub(crate) fn holds(&self, point: Vec3) -> bool {
        let steps = self.lattice.steps_to(point);
        let node = [0, 1, 2].map(|k| (steps[k] + 0.5).max(0.0) as usize);
        let within = (0..3).all(|k| node[k] < self.lattice.dims[k]);
        within && self.damage.near[self.lattice.index(node)]
    }

    /// The cells that the point may lie in: those of the nodes around it.
    pub(crate) fn cells_at(&self, point: Vec3) -> impl Iterator<Item = u32> + use<'_> {
        let node = self.lattice.node(self.lattice.nearest(point));
        self.lattice.around(node, 1).map(|i| self.reach[i])
    }

    /// Finds the nodes with damage within two units along every axis.
    fn look_around(&mut self) {
        let mut near = vec![false; self.lattice.len()];
        for i in (0..near.len()).filter(|&i| self.is_damaged(i)) {
            for j in self.lattice.around(self.lattice.node(i), self.steps(2.0)) {
                near[j] = true;
            }
        }
        self.damage.near = near;
    }
}

/// The found piece with the most of some shares, or `None` for all sampled ones together, where
/// they have more: were each of them to stand alone, the found piece would reach in between any
/// two.
fn most(pieces: &Pieces, shares: &[(Option<u32>, f64)]) -> Option<(Option<u32>, f64)> {
    let (mut drawn, mut found) = (0.0, None);
    for &(piece, share) in shares {
        match piece {
            Some(piece) if pieces.drawn(piece).is_some() => drawn += share,
            Some(piece) => {
                let more = found.is_none_or(|(other, most): (u32, f64)| {
                    share.total_cmp(&most).then(other.cmp(&piece)).is_gt()
                });
                found = if more { Some((piece, share)) } else { found };
            }
            None => {}
        }
    }
    match found {
        Some((piece, share)) if share >= drawn => Some((Some(piece), share)),
        _ => (drawn > 0.0).then_some((None, drawn)),
    }
}

fn check(field: &DamageField<'_>) -> Result<(), CutError> {
    let n = field.positions.len();
    let uneven = field.pieces.is_some_and(|pieces| pieces.of.len() != n)
        || field.normals.is_some_and(|normals| normals.len() != n);
    if n == 0 || uneven || field.damage.len() != n || field.damage_time.len() != n {
        let counts = [n, field.damage.len(), field.damage_time.len()];
        return Err(CutError::Lengths { counts });
    }
    if !(field.spacing > 0.0 && field.spacing.is_finite()) {
        return Err(CutError::NotFinite { what: "spacing", index: 0 });
    }
    let bad = |p: &Vec3| !p.iter().all(|x| x.is_finite());
    if let Some(index) = field.normals.and_then(|normals| normals.iter().position(bad)) {
        return Err(CutError::NotFinite { what: "normal", index });
    }
    if let Some(index) = field.positions.iter().position(bad) {
        return Err(CutError::NotFinite { what: "position", index });
    }
    if let Some(index) = field.damage.iter().position(|d| !(0.0..=1.0).contains(d)) {
        return Err(CutError::NotFinite { what: "damage in [0, 1]", index });
    }
    if let Some(index) = field.damage_time.iter().position(|t| t.is_nan() || *t < 0.0) {
        return Err(CutError::NotFinite { what: "damage time", index });
    }
    Ok(())
}
