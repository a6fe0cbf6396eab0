//! Points of soft walls that are not simply elastic: they flow, open, tear and heal.
//!
//! With W the energy of a whole station and W₁ that of one that is parted along the crack, a
//! cracked point has ψ = (1 − c)W + cW₁, and what drives c is the stress √(2f(W − W₁)) with
//! f = E/(1 − ν²): that of the same energy in linear elasticity. So a crack costs G_f whatever the
//! strain at which it opens, and the softening of [`SectionLaw::softening`] holds as it is.

use super::crack::{CrackLine, CrackSoftening};
use super::plane::{principal, turned, turned_back};
use super::soft::{SoftElasticity, SoftSection};
use super::yielding::{StationFlow, less, times};
use super::{PointState, SectionLaw, SectionTally};
use crate::kernel::{Resultants, SurfaceStrain};

/// Strain of a broken point that has not healed above which it bears nothing any more: what moves
/// it has gone elsewhere \[1\].
const MOST_STRAIN: f64 = 1.5;

/// Share of the strength at which a point is followed step by step, of the linear stress that its
/// Green strain would make: that is above the stress which counts, in tension.
const NEAR_STRENGTH: f64 = 0.8;

impl SectionLaw {
    /// Of a soft wall: with three stations, or five where it yields.
    #[must_use]
    pub fn soft(self, section: SoftSection) -> Self {
        let count = if self.hardening.is_some() { 5 } else { 3 };
        Self { stations: super::lobatto(count), soft: Some(section), ..self }
    }

    /// As [`SectionLaw::elastic_limit`], of a soft wall.
    pub(super) fn soft_limit(&self, state: &PointState) -> Option<f64> {
        if state.crack.is_some() || state.crumbles || !state.flow.is_empty() {
            return None;
        }
        let strength = NEAR_STRENGTH * state.in_force(0.0);
        Some(self.hardening.map_or(strength, |flow| strength.min(flow.yield_stress)))
    }

    /// As [`SectionLaw::step`], of a soft wall.
    pub(super) fn tear(
        &self,
        soft: &SoftSection,
        state: &mut PointState,
        strain: &SurfaceStrain,
        tally: &mut SectionTally,
    ) -> Resultants {
        if state.dead {
            return Resultants::default();
        }
        if state.crumbles && !state.is_broken() {
            tally.dissipated += state.area * self.soft_energy(soft, state, strain);
            tally.broken += 1;
            state.dead = true;
            return Resultants::default();
        }
        if state.crack.is_none() {
            self.yields(soft, state, strain, tally);
            self.starts(soft, state, strain);
        }
        if let Some(crack) = state.crack
            && !state.is_broken()
        {
            self.grows(soft, state, &crack, strain, tally);
        }
        if state.is_broken() {
            self.crosses(soft, state, strain, tally);
        }
        let is_special = state.crack.is_some() || !state.flow.is_empty();
        state.last = is_special.then_some(*strain);
        self.soft_borne(soft, state, strain)
    }

    /// Strain of a station as its elasticity has it.
    fn elastic_strain(
        soft: &SoftSection,
        state: &PointState,
        strain: &SurfaceStrain,
        (station, z): (usize, f64),
    ) -> [f64; 3] {
        let height = z * state.thickness * soft.bend;
        let e = match &state.set {
            Some(set) => less(&strain.at(height), &set.at(height)),
            None => strain.at(height),
        };
        state.flow.get(station).map_or(e, |flow| less(&e, &flow.strain))
    }

    /// Lets stations flow that bear more than the yield stress.
    fn yields(
        &self,
        soft: &SoftSection,
        state: &mut PointState,
        strain: &SurfaceStrain,
        tally: &mut SectionTally,
    ) {
        let Some(hardening) = &self.hardening else { return };
        let (t, stations) = (state.thickness, self.stations.list());
        let is_fresh = state.flow.is_empty();
        if is_fresh {
            state.flow.resize(stations.len(), StationFlow::default());
        }
        let mut flows = false;
        for (&(z, w), flow) in stations.iter().zip(&mut state.flow) {
            let (then, height) = (*flow, z * t * soft.bend);
            let stress = flow.flow(&self.elastic, hardening, &strain.at(height));
            if *flow == then {
                continue;
            }
            flows = true;
            let first = |before: SurfaceStrain| {
                self.elastic.stress(&less(&before.at(height), &then.strain))
            };
            let first = state.last.map_or(stress, first);
            let mean = [0, 1, 2].map(|k| 0.5 * (first[k] + stress[k]));
            let work = times(&mean, &less(&flow.strain, &then.strain));
            tally.plastic += state.area * t * w * work;
        }
        if is_fresh && !flows {
            state.flow.clear();
        }
    }

    /// The stress that has the energy which a crack across `normal` would set free at a station
    /// \[Pa\]; none where it is pressed.
    fn drive(&self, soft: &SoftSection, e: &[f64; 3], normal: [f64; 2]) -> f64 {
        let local = turned(e, normal);
        if soft.elastic.stress(&[local[0], local[1], 0.0])[0] <= 0.0 {
            return 0.0;
        }
        let free = soft.elastic.energy(&local) - soft.elastic.parted(&local).0;
        (2.0 * self.elastic.modulus * free.max(0.0)).sqrt()
    }

    /// The greatest of a station's drive and the mean, in energy \[Pa\].
    fn soft_drives(
        &self,
        soft: &SoftSection,
        state: &PointState,
        normal: [f64; 2],
        strain: &SurfaceStrain,
    ) -> (f64, f64) {
        let (mut worst, mut mean) = (0.0_f64, 0.0);
        for (station, &(z, w)) in self.stations.list().iter().enumerate() {
            let e = Self::elastic_strain(soft, state, strain, (station, z));
            let drive = self.drive(soft, &e, normal);
            worst = worst.max(drive);
            mean += w * drive * drive;
        }
        (worst, mean.sqrt())
    }

    /// Opens a crack where the worst face bears more than the strength.
    fn starts(&self, soft: &SoftSection, state: &mut PointState, strain: &SurfaceStrain) {
        if !state.flaw.is_finite() {
            return;
        }
        let stations = self.stations.list();
        let at = |station: usize| {
            Self::elastic_strain(soft, state, strain, (station, stations[station].0))
        };
        let faces = [0, stations.len() - 1].map(|station| {
            let e = at(station);
            (principal(&soft.elastic.stress(&e)), e)
        });
        let ((stress, normal), e) = if faces[1].0.0 > faces[0].0.0 { faces[1] } else { faces[0] };
        if stress <= 0.0 {
            return;
        }
        let worst = self.drive(soft, &e, normal);
        if worst <= state.in_force(0.0) {
            return;
        }
        let middle = self.drive(soft, &at(stations.len() / 2), normal);
        let bending_share = (1.0 - middle / worst).clamp(0.0, 1.0);
        let strength = state.in_force(bending_share);
        if worst <= strength {
            return;
        }
        let side = turned(&strain.bending, normal)[0].signum();
        let length = state.length(normal);
        // The mean stress when the worst face bore the strength.
        let mean = self.soft_drives(soft, state, normal, strain).1 * strength / worst;
        let softens = |strength: f64, share: f64| CrackSoftening {
            hardness: self.softening(strength, length, share),
            strength,
        };
        let (worst, mean) = (softens(strength, bending_share), softens(mean, 0.0));
        state.crack = Some(CrackLine { normal, bending_share, side, worst, mean });
    }

    /// Lets c grow.
    fn grows(
        &self,
        soft: &SoftSection,
        state: &mut PointState,
        crack: &CrackLine,
        strain: &SurfaceStrain,
        tally: &mut SectionTally,
    ) {
        let (worst, mean) = self.soft_drives(soft, state, crack.normal, strain);
        if worst <= 0.0 || !state.flaw.is_finite() {
            return;
        }
        let wanted = crack.worst.damage(worst).max(crack.mean.damage(mean));
        let growth = (wanted.min(1.0) - state.damage).min(self.most_growth);
        if growth <= 0.0 || growth.is_nan() {
            return;
        }
        // What damage takes is taken in the middle of the step: at its end it would be too much.
        let middle = state.last.map_or(*strain, |last| last.middle(strain));
        let before = self.soft_energy(soft, state, &middle);
        state.damage += growth;
        if state.is_broken() {
            state.damage = 1.0;
            tally.broken += 1;
        }
        tally.dissipated += state.area * (before - self.soft_energy(soft, state, &middle));
    }

    /// A second crack across the first takes what is left; so does the end of a crumb.
    fn crosses(
        &self,
        soft: &SoftSection,
        state: &mut PointState,
        strain: &SurfaceStrain,
        tally: &mut SectionTally,
    ) {
        let Some(crack) = state.crack else { return };
        let mut worst = 0.0_f64;
        for (station, &(z, _)) in self.stations.list().iter().enumerate() {
            let e = Self::elastic_strain(soft, state, strain, (station, z));
            let (energy, stress) = soft.elastic.strip(turned(&e, crack.normal)[1]);
            if stress > 0.0 {
                worst = worst.max((2.0 * self.material.young * energy.max(0.0)).sqrt());
            }
        }
        let strained = strain.membrane.iter().fold(0.0_f64, |most, e| most.max(e.abs()));
        let is_lost = state.set.is_none() && strained > MOST_STRAIN;
        if worst > state.flaw || state.crumbles || is_lost {
            tally.dissipated += state.area * self.soft_energy(soft, state, strain);
            tally.broken += 1;
            state.dead = true;
            state.crossed = worst > state.flaw;
        }
    }

    /// Energy a volume \[J/m³\] and stress \[Pa\] of a station.
    fn station(soft: &SoftSection, state: &PointState, e: &[f64; 3]) -> (f64, [f64; 3]) {
        let elastic = &soft.elastic;
        let Some(crack) = state.crack.filter(|_| state.set.is_none()) else {
            return (elastic.energy(e), elastic.stress(e));
        };
        let local = turned(e, crack.normal);
        if state.is_broken() {
            // What is cut bears no pressure: its sides meet by contact (F81).
            let (energy, along) = elastic.strip(local[1]);
            return (energy, turned_back(&[0.0, along, 0.0], crack.normal));
        }
        let (left, borne) = elastic.parted(&local);
        let (whole, stress) = (elastic.energy(e), elastic.stress(e));
        let (borne, c) = (turned_back(&borne, crack.normal), state.damage);
        let mixed = |k: usize| (1.0 - c) * stress[k] + c * borne[k];
        ((1.0 - c) * whole + c * left, [0, 1, 2].map(mixed))
    }

    /// As [`SectionLaw::borne`], of a soft wall.
    pub(super) fn soft_borne(
        &self,
        soft: &SoftSection,
        state: &PointState,
        strain: &SurfaceStrain,
    ) -> Resultants {
        let mut borne = Resultants::default();
        if state.dead {
            return borne;
        }
        for (station, &(z, w)) in self.stations.list().iter().enumerate() {
            let e = Self::elastic_strain(soft, state, strain, (station, z));
            let stress = Self::station(soft, state, &e).1;
            borne.add(state.thickness, (z * soft.bend, w), &stress);
        }
        borne
    }

    /// As [`SectionLaw::energy`], of a soft wall.
    pub(super) fn soft_energy(
        &self,
        soft: &SoftSection,
        state: &PointState,
        strain: &SurfaceStrain,
    ) -> f64 {
        if state.dead {
            return 0.0;
        }
        let at = |(station, &(z, w)): (usize, &(f64, f64))| {
            let e = Self::elastic_strain(soft, state, strain, (station, z));
            w * state.thickness * Self::station(soft, state, &e).0
        };
        self.stations.list().iter().enumerate().map(at).sum()
    }

    /// Energy of a point over its area that is not of bending: of the mean elastic strain through
    /// the thickness \[J/m²\].
    pub(crate) fn stretching(&self, state: &PointState, strain: &SurfaceStrain) -> f64 {
        let Some(soft) = &self.soft else { return 0.0 };
        if state.dead {
            return 0.0;
        }
        let mut mean = [0.0; 3];
        for (station, &(z, w)) in self.stations.list().iter().enumerate() {
            let e = Self::elastic_strain(soft, state, strain, (station, z));
            (0..3).for_each(|k| mean[k] += w * e[k]);
        }
        state.thickness * Self::station(soft, state, &mean).0
    }

    /// How much stiffer a point is than before anything moved, where it is pressed together \[1\].
    pub(crate) fn stiffening(&self, state: &PointState, strain: &SurfaceStrain) -> f64 {
        let Some(soft) = &self.soft else { return 1.0 };
        let SoftElasticity::NeoHookean(law) = &soft.elastic else { return 1.0 };
        // What is broken bears nothing across its crack, however its sides lie.
        if state.dead || (state.is_broken() && state.set.is_none()) {
            return 1.0;
        }
        let stations = self.stations.list().iter().enumerate();
        let at = |(station, &(z, _)): (usize, &(f64, f64))| {
            law.stiffening(&Self::elastic_strain(soft, state, strain, (station, z)))
        };
        stations.map(at).fold(1.0, f64::max)
    }
}
