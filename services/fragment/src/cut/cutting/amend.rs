//! Second thoughts: pieces that join a neighbour after a first cut.

use super::{Cutting, Piece};
use cullet_geometry::boolean::Exact;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::{Solid, Vec3};
use std::collections::BTreeMap;

/// What a union leaves beside its main part may have this share of the body's volume: rounding.
const REST: f64 = 1e-12;

impl Cutting {
    /// Gives the cells of pieces that join a host, and are all there is of their label, to the
    /// host's label, and notes what has to be cut again. False if there is no such piece.
    pub(super) fn relabel(&mut self, groups: &[u32]) -> bool {
        let mut count = vec![0; self.sides.len()];
        for piece in &self.pieces {
            count[piece.label as usize] += 1;
        }
        let mut dirty = vec![false; self.sides.len()];
        let mut name: Vec<u32> = (0..self.sides.len() as u32).collect();
        for (piece, &host) in self.pieces.iter().zip(groups) {
            let (from, to) = (piece.label, self.pieces[host as usize].label);
            if from != to && count[from as usize] == 1 {
                name[from as usize] = to;
                dirty[from as usize] = true;
                dirty[to as usize] = true;
            }
        }
        if !dirty.contains(&true) {
            return false;
        }
        for label in &mut self.labels {
            *label = name[*label as usize];
        }
        self.sides = self.mosaic.sides(&self.labels, self.sides.len());
        self.pieces.retain(|piece| !dirty[piece.label as usize]);
        self.todo = (0..dirty.len() as u32).filter(|&label| dirty[label as usize]).collect();
        self.cut = 0;
        true
    }

    /// Joins pieces with siblings elsewhere (cells reach across gaps) to their hosts, solid to
    /// solid. What the kernel cannot join stays.
    pub(super) fn join(&mut self, groups: &[u32]) {
        let mut gone = vec![false; self.pieces.len()];
        let mut left = 0;
        for (p, &host) in groups.iter().enumerate() {
            let host = host as usize;
            if host == p {
                continue;
            }
            match self.union(host, p) {
                Some(mut joined) => {
                    joined.also.extend(self.pieces[host].also.iter().copied());
                    joined.also.extend(self.pieces[p].also.iter().copied());
                    joined.also.push(self.pieces[p].label);
                    self.pieces[host] = joined;
                    gone[p] = true;
                }
                None => left += 1,
            }
        }
        if left > 0 {
            self.warnings.push(format!("{left} small parts could not be joined to a neighbour"));
        }
        let mut gone = gone.into_iter();
        self.pieces.retain(|_| !gone.next().unwrap_or(false));
    }

    /// Two pieces as one, if they touch along a face.
    fn union(&self, host: usize, other: usize) -> Option<Piece> {
        let (a, b) = (&self.pieces[host], &self.pieces[other]);
        let whole: Exact = a.exact.union(&b.exact).ok()?;
        let mut parts = whole.components().ok()?.into_iter();
        let main = parts.next()?;
        let rest: f64 = parts.map(|part| part.volume()).sum();
        if rest > REST * self.body.volume {
            return None;
        }
        let piece = self.piece(a.label, main).ok()?;
        let sum = a.volume + b.volume;
        ((piece.volume - sum).abs() <= REST * self.body.volume).then_some(piece)
    }
}

/// Tells which of several solids a point belongs to.
pub(super) struct Homes(BTreeMap<u32, (Inside, Nearest)>);

impl Homes {
    pub(super) fn new<'a>(solids: impl Iterator<Item = (u32, &'a Solid)>) -> Self {
        let tests = |s: &Solid| (Inside::new(&s.mesh), Nearest::new(&s.mesh));
        Self(solids.map(|(name, solid)| (name, tests(solid))).collect())
    }

    /// The one of `among` (at least one) that contains the point, or else the closest.
    pub(super) fn of(&self, point: Vec3, among: &[u32]) -> u32 {
        if let Some(&home) = among.iter().find(|name| self.0[name].0.contains(point)) {
            return home;
        }
        let distance = |name: &u32| self.0[name].1.distance(point);
        let nearer = |a: &&u32, b: &&u32| distance(a).total_cmp(&distance(b));
        among.iter().min_by(nearer).copied().unwrap_or_default()
    }
}
