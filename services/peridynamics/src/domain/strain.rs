//! Both passes over the bonds of a body.

use super::parts::{MovingParts, PartFrames};
use super::{MaterialPoint, PeridynamicDomain};
use crate::bonds::BondSlot;
use crate::frame::CorotatedFrame;
use crate::kernel::{PullBlock, PullModuli, PullPass, StretchPass};
use cullet_geometry::Vec3;
use cullet_simd::Lanes;
use fearless_simd::{Simd, dispatch};
use nalgebra::Rotation3;
use rayon::prelude::*;

/// Points whose bonds are looked at together.
const BLOCK: usize = 256;

/// A displacement over the horizon that is none: squares of less would be subnormal in f32.
const STILL: f64 = 1e-12;

/// What the bonds of a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BondTally {
    /// Energy that flow took \[J\].
    pub plastic: f64,
    /// Energy that breaking took \[J\]. What bonds bore before and after a step counts, so that it
    /// is too low where bonds are drawn from pressed to broken in one.
    pub broken: f64,
    /// Bonds that were so drawn: the step is too long for what hits the body.
    pub jumped: usize,
    /// Energy that `broken` lacks for them \[J\].
    pub unbooked: f64,
    /// Energy that friction took \[J\].
    pub friction: f64,
    /// Energy that dashpots and the air took \[J\].
    pub damped: f64,
    /// Points that flowed.
    pub yielding: usize,
}

/// Some points in a row, and what the first pass writes of them.
struct StrainBlock<'a> {
    /// The first of them.
    first: usize,
    states: &'a mut [MaterialPoint],
    left: &'a mut [Lanes<f32>],
    /// Mean extension, and what yielding left of z.
    responses: &'a mut [[f32; 2]],
}

impl BondTally {
    /// Both together.
    #[must_use]
    pub fn plus(self, more: Self) -> Self {
        Self {
            plastic: self.plastic + more.plastic,
            broken: self.broken + more.broken,
            jumped: self.jumped + more.jumped,
            unbooked: self.unbooked + more.unbooked,
            friction: self.friction + more.friction,
            damped: self.damped + more.damped,
            yielding: self.yielding + more.yielding,
        }
    }
}

impl PeridynamicDomain {
    /// Says which points move together, by equal labels: displacements of each part are counted
    /// from where that part is, so that parts may fly far from each other. No bond may be left
    /// between two of them.
    pub(crate) fn move_apart(&mut self, labels: &[u32]) {
        self.parts = MovingParts::new(labels);
    }

    /// How the part of each point is turned.
    pub(crate) fn turns(&self) -> Vec<Rotation3<f64>> {
        let frames = self.parts.frames(&self.places, &self.reference);
        (0..self.places.len()).map(|p| frames.of(p).turn).collect()
    }

    /// Softens and strains the bonds, lets points flow, and finds the forces.
    pub fn strain(&mut self) -> BondTally {
        self.strain_after(0.0)
    }

    /// The same after a step of `dt` \[s\] with the velocities as they are.
    pub(crate) fn strain_after(&mut self, dt: f64) -> BondTally {
        let law = &self.law;
        let breaks = law.breaking.is_some() || law.ductile.is_some();
        self.make_room(breaks, law.hardening.is_some());
        let parts = std::mem::take(&mut self.parts);
        let frames = match parts.is_empty() {
            true => PartFrames::one(self.frame()),
            false => parts.frames(&self.places, &self.reference),
        };
        self.turn = frames.of(0).turn;
        self.pack(&frames);
        let mut responses = vec![[0.0; 2]; self.places.len()];
        let mut tally = self.stretch(dt, &mut responses);
        let both = self.records.par_iter_mut().zip(&responses);
        both.for_each(|(record, response)| [record.0[3], record.0[7]] = *response);
        self.pull();
        if self.law.damping.bonds > 0.0 {
            tally.damped = self.drag(&frames, dt);
        }
        let scale = self.mean_volume / self.horizon;
        let turned = |(p, force): (usize, &mut Vec3)| *force = frames.of(p).turn * (*force * scale);
        self.forces.par_iter_mut().enumerate().for_each(turned);
        self.drags.par_iter_mut().enumerate().for_each(turned);
        self.parts = parts;
        if let Some(contact) = self.law.contact {
            tally.friction = self.push_apart(&contact, dt);
        }
        tally
    }

    /// Where the body is as a whole, without what has come off.
    fn frame(&self) -> CorotatedFrame {
        if self.states.iter().all(|state| state.damage < 1.0) {
            return CorotatedFrame::of(&self.places, &self.reference, &self.turn);
        }
        let rest = || (0..self.places.len()).filter(|&p| !self.is_debris(p));
        let places: Vec<Vec3> = rest().map(|p| self.places[p]).collect();
        let reference: Vec<Vec3> = rest().map(|p| self.reference[p]).collect();
        CorotatedFrame::of(&places, &reference, &self.turn)
    }

    /// Writes displacements and damage to the records; debris stays where it was, however far it
    /// flies.
    fn pack(&mut self, frames: &PartFrames<'_>) {
        let horizon = self.horizon;
        let points = self.places.par_iter().zip(&self.reference).zip(&self.states).enumerate();
        self.records.par_iter_mut().zip(points).for_each(|(record, (p, ((x, at), state)))| {
            let frame = frames.of(p);
            let moved = (frame.turn.inverse() * (x - frame.centre) - at) / horizon;
            for (packed, u) in record.0[4..7].iter_mut().zip(moved.iter()) {
                *packed = if u.abs() < STILL || state.damage >= 1.0 { 0.0 } else { *u as f32 };
            }
            [record.0[3], record.0[7]] = [state.ductile as f32, state.damage as f32];
        });
    }

    /// The first pass.
    fn stretch(&mut self, dt: f64, responses: &mut [[f32; 2]]) -> BondTally {
        let mut states = std::mem::take(&mut self.states);
        let mut left = std::mem::take(&mut self.left);
        let mut blocks = Vec::new();
        let mut rest = &mut left[..];
        let points = states.chunks_mut(BLOCK).zip(responses.chunks_mut(BLOCK));
        for (k, (states, responses)) in points.enumerate() {
            let first = k * BLOCK;
            let (own, after) = split(rest, self.groups(first, states.len()));
            rest = after;
            blocks.push(StrainBlock { first, states, left: own, responses });
        }
        let (body, level) = (&*self, self.level.level());
        let pass = StretchPass {
            bonds: &body.bonds,
            records: &body.records,
            flowed: [&body.flowed[0], &body.flowed[1]],
            breaking: body.law.breaking.map(|how| (how, body.critical)),
            strength: body.law.anisotropy,
            strengths: &body.strengths,
            weakest: body.strengths.iter().copied().fold(1.0, f32::min),
            ductile: body.law.ductile.is_some(),
            limited: body.law.max_plastic_stretch.is_some(),
        };
        let tallies: Vec<BondTally> = blocks
            .into_par_iter()
            .map_init(Vec::new, |before, block| {
                dispatch!(level, simd => body.stretch_block(simd, &pass, dt, block, before))
            })
            .collect();
        (self.states, self.left) = (states, left);
        tallies.into_iter().fold(BondTally::default(), BondTally::plus)
    }

    /// The first pass over some points in a row.
    #[inline(always)]
    fn stretch_block<S: Simd>(
        &self,
        simd: S,
        pass: &StretchPass<'_>,
        dt: f64,
        block: StrainBlock<'_>,
        before: &mut Vec<(BondSlot, f32)>,
    ) -> BondTally {
        let StrainBlock { first, states, left, responses } = block;
        let origin = self.bonds.groups(first).start;
        let mut tally = BondTally::default();
        for (k, (state, response)) in states.iter_mut().zip(responses).enumerate() {
            let point = first + k;
            let own = match left.is_empty() {
                true => &mut [],
                false => {
                    let groups = self.bonds.groups(point);
                    &mut left[groups.start - origin..groups.end - origin]
                }
            };
            before.clear();
            let sums = pass.point(simd, point, state.mean as f32, own, before);
            if !before.is_empty() && point < self.own {
                tally = tally.plus(self.softened(point, own, before, dt));
            }
            let whole = f64::from(sums.whole) / f64::from(self.totals[point]);
            let mut shrink = 1.0;
            let deviation = f64::from(sums.deviation);
            let held = (1.0 - state.damage).max(f64::MIN_POSITIVE);
            let before = self.law.equivalent_stress(state.deviation / held);
            if let Some(yielded) = self.law.yields(deviation, state.plastic) {
                let yielded = self.law.limited(yielded, deviation, &sums.flowed);
                shrink = yielded.left as f32;
                state.plastic += yielded.strain;
                let borne = yielded.left * self.law.equivalent_stress(deviation);
                // Central differences take the work of what was borne before and after a step, and
                // not of what would have been.
                let work = match dt > 0.0 {
                    true => 0.5 * (before + borne) * yielded.strain,
                    false => yielded.work,
                };
                if let Some(ductile) = self.law.ductile {
                    let triaxiality = 3.0 * self.law.bulk * f64::from(sums.mean) / borne;
                    state.ductile += yielded.strain / ductile.strain(triaxiality);
                }
                if point < self.own {
                    tally.plastic += self.volumes[point] * whole * work;
                    tally.yielding += 1;
                }
            }
            let left = f64::from(shrink) * f64::from(shrink);
            state.deviation = whole * left * deviation;
            (state.mean, state.damage) = (f64::from(sums.mean), 1.0 - whole);
            *response = [sums.mean, shrink];
        }
        tally
    }

    /// What became of the bonds of a point which had the `before` left and have `left` now. Central
    /// differences take the energy of what was and what is, not of either.
    #[inline(never)]
    fn softened(
        &self,
        point: usize,
        left: &[Lanes<f32>],
        before: &[(BondSlot, f32)],
        dt: f64,
    ) -> BondTally {
        let origin = self.bonds.groups(point).start;
        let bonds: Vec<SoftenedBond> = self
            .bonds
            .of(point)
            .map(|b| {
                let apart = self.places[b.end] - self.places[point];
                let came = (self.velocities[b.end] - self.velocities[point]) * dt;
                let extension = |along| self.elastic_extension(point, b, along);
                let now = left[b.group - origin].0[b.lane];
                let old = before.iter().find(|(other, _)| *other == b).map_or(now, |old| old.1);
                let weight = self.weight(point, b);
                let weights = [old, now].map(|left| weight * f64::from(left));
                SoftenedBond { weights, extensions: [extension(apart - came), extension(apart)] }
            })
            .collect();
        let energy = |k: usize| {
            let sum = |of: &dyn Fn(&SoftenedBond) -> f64| {
                bonds.iter().map(|bond| bond.weights[k] * of(bond)).sum::<f64>()
            };
            let whole = sum(&|_| 1.0);
            if whole <= 0.0 {
                return 0.0;
            }
            let [one, two] = [0, 1].map(|when| sum(&|bond| bond.extensions[when]) / whole);
            let product = sum(&|bond| (bond.extensions[0] - one) * (bond.extensions[1] - two));
            self.law.energy(whole, 1.0, 0.0) * one * two + self.law.energy(0.0, 0.0, product)
        };
        let broken = self.volumes[point] * (energy(0) - energy(1));
        let mut tally = BondTally { broken, ..BondTally::default() };
        for (bond, slot) in bonds.iter().zip(self.bonds.of(point)) {
            let [was, is] = bond.extensions;
            if bond.weights[0] > 0.0 && bond.weights[1] == 0.0 && was < 0.0 && is > 0.0 {
                // It bears ever more up to s_c/2, then ever less up to s_c.
                let due = 3.75 * self.critical * self.critical - 7.5 * was * is;
                tally.unbooked += self.volumes[point] * bond.weights[0] * self.law.shear * due;
                tally.jumped += usize::from(point < slot.end);
            }
        }
        tally
    }

    /// The second pass.
    fn pull(&mut self) {
        let mut forces = std::mem::take(&mut self.forces);
        let mut flowed = std::mem::take(&mut self.flowed);
        let [own, back] = &mut flowed;
        let (mut own, mut back) = (&mut own[..], &mut back[..]);
        let mut blocks = Vec::new();
        for (k, forces) in forces.chunks_mut(BLOCK).enumerate() {
            let first = k * BLOCK;
            let groups = self.groups(first, forces.len());
            let (one, other) = (split(own, groups), split(back, groups));
            (own, back) = (one.1, other.1);
            blocks.push(PullBlock { first, forces, flowed: [one.0, other.0] });
        }
        let pass = PullPass {
            bonds: &self.bonds,
            records: &self.records,
            moduli: PullModuli::of(&self.law),
            left: &self.left,
        };
        let level = self.level.level();
        blocks.into_par_iter().for_each(|block| dispatch!(level, simd => pass.run(simd, block)));
        (self.forces, self.flowed) = (forces, flowed);
    }

    /// Groups of `number` points from `first`.
    fn groups(&self, first: usize, number: usize) -> usize {
        self.bonds.groups(first + number - 1).end - self.bonds.groups(first).start
    }
}

/// A bond of a point where some have softened.
struct SoftenedBond {
    /// wk before and now \[1\].
    weights: [f64; 2],
    /// q − e_p a step before and now \[1\].
    extensions: [f64; 2],
}

/// The first `number` of a list, which may be empty instead, and the others.
fn split<T>(list: &mut [T], number: usize) -> (&mut [T], &mut [T]) {
    let number = number.min(list.len());
    list.split_at_mut(number)
}
