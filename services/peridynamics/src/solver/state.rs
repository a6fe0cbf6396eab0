//! A solve: its body, what presses on it, and what it has seen so far.

use super::body::PressedDomain;
use crate::domain::StrainLimit;
use cullet_fragment::kinetic_damping::KineticDamping;
use cullet_fragment::press::RigidPress;
use cullet_fragment::surface_particles::SurfaceParticles;
use cullet_model::{BondedSolid, BrittleProblem, Failure};
use cullet_simd::SimdLevel;

/// Excess of energy over what was given, above which a solve has failed \[1\].
const UNSTABLE: f64 = 0.1;

/// Share of the energy of the hits below which flow and breaking count as none \[1\].
pub(super) const NO_CHANGE: f64 = 1e-3;

/// The peridynamic family.
#[derive(Debug)]
pub struct Peridynamics {
    pub(super) problem: BrittleProblem,
    pub(super) bonds: BondedSolid,
    pub(super) body: PressedDomain,
    pub(super) points: SurfaceParticles,
    pub(super) strikers: Vec<RigidPress>,
    pub(super) supports: Vec<RigidPress>,
    /// L/c_s \[s\].
    pub(super) transit: f64,
    pub(super) setup: BondSetup,
    pub(super) settling: KineticDamping,
    pub(super) record: BondRecord,
}

/// How a solve is done.
#[derive(Clone, Copy, Debug)]
pub(super) struct BondSetup {
    /// Distance of points \[m\].
    pub(super) spacing: f64,
    /// How often it was begun again with half the step.
    pub(super) halvings: u32,
    pub(super) simd_level: SimdLevel,
}

/// What a solve has seen so far.
#[derive(Clone, Debug, Default)]
pub(super) struct BondRecord {
    /// Energy that flow took \[J\], ...
    pub(super) plastic: f64,
    /// ... that breaking took ...
    pub(super) broken: f64,
    /// ... and that friction, dashpots and the air took.
    pub(super) damped: f64,
    /// Energy that `broken` lacks, of bonds that jumped \[J\], and their number.
    pub(super) unbooked: (f64, usize),
    /// When so much more had flowed and broken as counts, and what both took then \[s\], \[J\].
    pub(super) changed: (f64, f64),
    pub(super) push_over: Option<f64>,
    /// Energy found less energy given, over that of the hits, where it was most \[1\].
    pub(super) energy_off: f64,
    pub(super) warnings: Vec<String>,
}

impl Peridynamics {
    /// The body as it is now.
    #[must_use]
    pub fn domain(&self) -> &crate::PeridynamicDomain {
        &self.body.domain
    }

    /// Of the hits \[J\].
    pub(super) fn energy(&self) -> f64 {
        self.problem.impacts.iter().map(|hit| hit.energy).sum()
    }

    pub(super) fn presses(&self) -> impl Iterator<Item = &RigidPress> {
        self.strikers.iter().chain(&self.supports)
    }

    /// Of the energy, and that the body is one that bonds hold for.
    pub(super) fn check(&mut self) -> Result<(), Failure> {
        let step = self.body.clock.steps;
        match self.body.domain.check() {
            Ok(()) => {}
            Err(StrainLimit::NoNumber { .. }) => {
                return Err(Failure::NotFinite { what: "a point's place or velocity", step });
            }
            Err(limit) => return Err(Failure::Beyond { what: limit.to_string(), step }),
        }
        let record = &self.record;
        let taken = record.plastic + record.broken + record.damped + self.settling.taken;
        let found = self.body.energy() + taken;
        if !found.is_finite() {
            return Err(Failure::NotFinite { what: "the body's energy", step });
        }
        let given: f64 = self.presses().map(|it| it.lost - it.stored - it.crushed).sum();
        let lost: f64 = self.strikers.iter().map(|it| it.lost).sum();
        let off = (found - given) / self.energy().max(lost);
        if off.abs() > self.record.energy_off.abs() {
            self.record.energy_off = off;
        }
        if off > UNSTABLE {
            return Err(Failure::Unstable { ratio: off, step });
        }
        Ok(())
    }
}
