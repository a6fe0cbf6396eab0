//! Cuts before anything happens, which sever links without breaking a point; and points that heal
//! behind a crack.

use super::state::ShellDomain;
use crate::kernel::SurfaceStrain;
use cullet_geometry::Vec3;
use cullet_simd::Real;

/// Greatest strain of a face with which a point heals \[1\]: it keeps that for good.
const MOST_SET: f64 = 0.2;

/// Points of a part of a soft shell below which it crumbles: its control points would move far more
/// freely than its points can hold.
const LEAST_SOFT_PART: usize = 16;

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Parts what lies on two sides: `parts` tells of two places \[m\] whether something has cut
    /// the line between them. Points ahead of where a cut ends feel its tip. How many links it
    /// severed.
    pub(crate) fn cut(&mut self, parts: impl Fn(&Vec3, &Vec3) -> bool) -> usize {
        let places: Vec<Vec3> = (0..self.points()).map(|p| self.links.place(p)).collect();
        let mut found = Vec::new();
        for (p, place) in places.iter().enumerate() {
            for (k, &q) in self.surface.around(p).iter().enumerate() {
                if q as usize > p && parts(place, &places[q as usize]) {
                    found.push((p, q as usize, self.surface.starts[p] as usize + k));
                }
            }
        }
        let mut beside = vec![false; places.len()];
        for &(p, q, entry) in &found {
            self.links.cut(&self.surface, entry, p);
            (beside[p], beside[q]) = (true, true);
        }
        let changed: Vec<u32> = (0..places.len() as u32).filter(|&p| beside[p as usize]).collect();
        self.part(&changed);
        for &(p, q, _) in &found {
            let facing = (places[q] - places[p]).normalize();
            let [e1, e2] = self.setup[self.seats[p]].surface.frame();
            self.announce_across(p, [facing.dot(&e1), facing.dot(&e2)], &facing);
        }
        // The sides of a cut are no weaker than the rest.
        for due in self.front.due.values_mut() {
            due.retain(|(point, _)| !beside[*point as usize]);
        }
        self.front.due.retain(|_, due| !due.is_empty());
        found.len()
    }

    /// Makes broken points whole again, from their present strains on, that share no control point
    /// any more with what they have parted from: a crack has given them to one side. What they
    /// still stored is lost \[J\].
    pub(crate) fn heal(&mut self) -> f64 {
        let waits = |&p: &usize| {
            let state = self.state(p);
            let is_open = state.is_broken() && !state.dead && state.set.is_none();
            is_open && !state.crumbles && self.is_given(p)
        };
        let waiting: Vec<usize> = self.live().filter(waits).collect();
        if waiting.is_empty() {
            return 0.0;
        }
        let strains: Vec<SurfaceStrain> = self.strains();
        let number: Vec<usize> = self.live().collect();
        let mut lost = 0.0;
        for p in waiting {
            let Ok(at) = number.binary_search(&p) else { continue };
            let (state, half) = (self.state(p), 0.5 * self.state(p).thickness);
            let faces = [half, -half].into_iter().flat_map(|z| strains[at].at(z));
            if faces.fold(0.0_f64, |most, e| most.max(e.abs())) > MOST_SET {
                continue;
            }
            lost += state.area * self.law.energy(state, &strains[at]);
            self.change(p, |state| state.set = Some(strains[at]));
        }
        lost
    }

    /// Whether a point has parted from some and shares no control point with those.
    fn is_given(&self, point: usize) -> bool {
        let own = self.functions(point).0;
        let parted = || self.joined(point).filter(|&(q, whole)| !whole && !self.state(q).dead);
        let shares = |q: usize| self.functions(q).0.iter().any(|node| own.contains(node));
        parted().next().is_some() && !parted().any(|(q, _)| shares(q))
    }

    /// Links that have been severed, by entry of the midsurface's list of neighbours, and points
    /// that bear nothing.
    pub(crate) fn parted_links(&self) -> (&[bool], &[bool]) {
        (&self.links.severed, &self.links.dead)
    }

    /// The part that each point is of, by the number of its first point. Points of parts that are
    /// too small, and dead ones, go with their neighbours.
    pub(crate) fn components(&self) -> Vec<u32> {
        let all: Vec<u32> = (0..self.points() as u32).collect();
        let mut label = vec![0; all.len()];
        for part in self.links.components(&self.surface, &all) {
            part.iter().for_each(|&p| label[p as usize] = part[0]);
        }
        label
    }

    /// Lets parts with too few points crumble, whose `labels` are those of
    /// [`ShellDomain::components`]; which points are crumbs now or bear nothing.
    pub(crate) fn crumble_parts(&mut self, labels: &[u32]) -> Vec<bool> {
        let is_lost = |p: usize| !self.is_on(p) || self.state(p).dead || self.state(p).crumbles;
        let mut crumbs: Vec<bool> = (0..labels.len()).map(is_lost).collect();
        let mut size = vec![0; labels.len()];
        for p in (0..labels.len()).filter(|&p| !crumbs[p]) {
            size[labels[p] as usize] += 1;
        }
        for p in 0..labels.len() {
            if !crumbs[p] && size[labels[p] as usize] < LEAST_SOFT_PART {
                self.change(p, |state| state.crumbles = true);
                crumbs[p] = true;
            }
        }
        crumbs
    }

    /// Whether each control point moves something: not where all its points bear nothing.
    pub(crate) fn moves(&self) -> Vec<bool> {
        let mut moves = vec![false; self.mass.len()];
        for p in self.live().filter(|&p| !self.state(p).dead) {
            let (nodes, shares) = self.functions(p);
            let any = nodes.iter().zip(shares).filter(|(_, share)| **share != 0.0);
            any.for_each(|(&n, _)| moves[n as usize] = true);
        }
        moves
    }

    /// Area of its cracks, length times thickness \[m²\]: what breaking their points costs over
    /// G_f.
    pub(crate) fn torn_area(&self) -> f64 {
        let of = |p: usize| {
            let state = self.state(p);
            let crack = state.crack.filter(|_| state.is_broken());
            crack.map_or(0.0, |c| state.area * state.thickness / state.length(c.normal))
        };
        self.live().map(of).sum()
    }
}
