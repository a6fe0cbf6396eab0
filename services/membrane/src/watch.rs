//! What is noticed as bonds break: how far beyond their end they were, and where and when the
//! first of a sheet broke.

use crate::bonds::MembraneBonds;
use crate::law::generalised;
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::table::BondTable;
use cullet_model::{MembraneLaw, SheetDiffusion};

/// Spacings that what spreads must have come before the first bond breaks by it (F83m).
const FRONT: f64 = 3.0;
/// Difference of free strain between neighbours, over s_c, above which it is that which breaks
/// them \[1\].
const STEEP: f64 = 0.5;
/// Bonds up to this length, in spacings, are between neighbours.
const NEIGHBOURS: f64 = 1.6;

/// A sheet and its bonds as they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BondsNow<'a> {
    pub(crate) prepared: &'a PreparedMembrane,
    pub(crate) state: &'a SheetState,
    pub(crate) table: &'a BondTable,
    /// \[s\].
    pub(crate) time: f64,
}

/// How the first bond of a sheet broke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FirstBreak {
    /// Number of a grip whose unbreakable strip it was next to, from 1 (F82m).
    pub(crate) grip: Option<usize>,
    /// How far what spreads had come, if that is too little \[m\].
    pub(crate) front: Option<f64>,
}

/// What a window notices.
#[derive(Clone, Debug, Default)]
pub(crate) struct TearWatch {
    /// Bonds that have broken so far, each from both ends.
    broken: Vec<bool>,
    /// Whether one had before this window.
    torn: bool,
    overshoot: f64,
    breaks: u32,
    /// Bonds over a parted line that were dropped (F84m).
    pub(crate) ties: u64,
    /// If it broke in this window.
    pub(crate) first: Option<FirstBreak>,
}

impl TearWatch {
    /// Begins with what is broken.
    pub(crate) fn new(bonds: &MembraneBonds, damage: &[f64]) -> Self {
        let broken: Vec<bool> = damage.iter().map(|&d| d >= 1.0).collect();
        let torn = broken.iter().zip(&bonds.cut).any(|(&broken, &cut)| broken && !cut);
        Self { broken, torn, ..Self::default() }
    }

    /// Mean of the stretch at which bonds of this window broke over that at which they should have
    /// \[1\] (F80m); 1 where none broke.
    pub(crate) fn overshoot(&self) -> f64 {
        if self.breaks == 0 { 1.0 } else { self.overshoot / f64::from(self.breaks) }
    }

    /// Looks at the bonds of points of which one has broken in the step just taken.
    pub(crate) fn note(&mut self, now: &BondsNow<'_>, torn: &[bool]) {
        let bonds = &now.prepared.bonds;
        for i in (0..torn.len()).filter(|&i| torn[i]) {
            for b in bonds.of(i) {
                if now.state.damage[b] < 1.0 || self.broken[b] {
                    continue;
                }
                self.broken[b] = true;
                self.broken[bonds.twins[b] as usize] = true;
                self.overshoot += now.overshoot(i, b);
                self.breaks += 1;
                let j = bonds.ends[b] as usize;
                if !std::mem::replace(&mut self.torn, true) {
                    self.first = Some(now.first_break([i, j], b));
                }
            }
        }
    }

    /// Counts ties that were dropped, each from both ends.
    pub(crate) fn drop_ties(&mut self, ties: &[usize]) {
        self.ties += ties.len() as u64 / 2;
        ties.iter().for_each(|&b| self.broken[b] = true);
    }
}

impl BondsNow<'_> {
    /// Stretch of a broken bond over that at which it should have broken; of a foil, its flow.
    fn overshoot(&self, i: usize, b: usize) -> f64 {
        let law = self.prepared.sheet().material.law;
        let limits = self.table.limits[b];
        let last = limits.critical * limits.critical / limits.first;
        if law == MembraneLaw::Foil {
            return self.state.flowed[b] / (2.0 / 3.0 * last);
        }
        let j = self.prepared.bonds.ends[b] as usize;
        let length = (self.state.places[j] - self.state.places[i]).norm();
        generalised(law, length * self.table.rest[b]) / last
    }

    fn first_break(&self, ends: [usize; 2], b: usize) -> FirstBreak {
        let places = &self.prepared.points.places;
        let [p, q] = ends.map(|i| places[i]);
        let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let sheet = self.prepared.sheet();
        let horizon = sheet.horizon * sheet.spacing;
        let grip = self
            .prepared
            .grips
            .iter()
            .position(|grip| grip.holds(self.time) && grip.is_next_to(middle, places, horizon));
        let mut quantities = sheet.diffusion.all.iter().enumerate();
        let front = quantities.find_map(|(number, what)| {
            let front = front(what, self.time)?;
            let steep = self.steepest(number, ends) > STEEP * self.table.limits[b].critical;
            (steep && front < FRONT * sheet.spacing).then_some(front)
        });
        FirstBreak { grip: grip.map(|k| k + 1), front }
    }

    /// Greatest difference of free strain by a quantity between two points and their neighbours
    /// \[1\].
    fn steepest(&self, quantity: usize, ends: [usize; 2]) -> f64 {
        let bonds = &self.prepared.bonds;
        let near = NEIGHBOURS * self.prepared.sheet().spacing;
        let what = &self.prepared.sheet().diffusion.all[quantity];
        let theta = self.state.theta_of(quantity);
        let swelling = |i: usize| what.swelling(theta[i]);
        let of = |i: usize| {
            let own = bonds.of(i).filter(|&b| bonds.lengths[b] <= near);
            own.map(move |b| (swelling(i) - swelling(bonds.ends[b] as usize)).abs())
        };
        ends.into_iter().flat_map(of).fold(0.0, f64::max)
    }
}

/// √(Dt): how far what spreads has come by a time \[m\], if any has.
fn front(what: &SheetDiffusion, time: f64) -> Option<f64> {
    let began = what.sources.iter().map(|source| source.from).fold(f64::INFINITY, f64::min);
    let [along, across] = what.conductivity;
    (began < time).then(|| (along.max(across) / what.capacity * (time - began)).sqrt())
}
