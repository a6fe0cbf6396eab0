//! The law of a section: stress over the thickness, cracks of a fixed direction, their energy.
//!
//! One damage value a point for the whole thickness: damage layer by layer does not localise in
//! bending (F79). A crack keeps the direction that it had at onset, and
//! the stress follows from a potential (F82); with e = ε_nn + νε_tt and f = E/(1 − ν²),
//! ψ = ½Eε_tt² + (1 − c\[e>0\]) ½fe² + (1 − c) 2με_nt².

mod crack;
mod plane;
mod plastic;
mod soft;
mod stations;
mod tearing;
mod yielding;

pub(crate) use crack::CrackSoftening;
pub use crack::{CrackLine, PointState};
pub(crate) use soft::LEAST_AREA;
pub use soft::{NeoHookean, SoftElasticity, SoftSection};
pub use stations::{Stations, gauss, lobatto};
pub use yielding::StationFlow;

use crate::kernel::PlaneStress;
use cullet_model::{Hardening, Material};

/// Share of damage at which a point is broken: then it bears nothing across its crack.
pub const BROKEN: f64 = 0.999;

/// Work of a section broken in pure bending over that of one torn in its plane is 1 − this \[S21\].
pub const BENDING_RELIEF: f64 = 0.78;

/// Most of x = sσ_f²l_c/(2fG_f) that the softening goes by: at 1 it would be sudden.
const MOST_BRITTLE: f64 = 0.98;

/// Stations through the thickness.
const STATIONS: usize = 5;

/// Stations through the thickness of what yields: the plastic moment within 3 %.
const YIELDING_STATIONS: usize = 7;

/// Slack over the yield stress below which a section is followed step by step.
const NEAR_YIELD: f64 = 0.1;

/// Strain of a broken section that no brittle material bears \[1\].
const MOST_STRAIN: f64 = 0.02;

/// Most that damage grows in a step \[1\].
const MOST_GROWTH: f64 = 0.25;

/// What the law of a section goes by.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionLaw {
    /// Elasticity before any crack.
    pub elastic: PlaneStress,
    /// What it is made of.
    pub material: Material,
    /// Stations through the thickness.
    pub stations: Stations,
    /// Most that damage grows in a step \[1\].
    pub most_growth: f64,
    /// Strain at a face above which a broken section bears nothing any more \[1\].
    pub most_strain: f64,
    /// How it yields, where it does. What yields does not crack, unless it is soft.
    pub hardening: Option<Hardening>,
    /// Of a soft wall; `None` of one whose strains are small.
    pub soft: Option<SoftSection>,
}

/// What a step did at some points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionTally {
    /// Energy that damage took, and of walls that are not soft what flowed \[J\].
    pub dissipated: f64,
    /// Plastic work of soft walls \[J\].
    pub plastic: f64,
    /// What inner damping of soft walls took \[J\].
    pub damped: f64,
    /// Points that broke, or broke a second time.
    pub broken: u32,
}

impl SectionTally {
    /// Sum of two.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            dissipated: self.dissipated + other.dissipated,
            plastic: self.plastic + other.plastic,
            damped: self.damped + other.damped,
            broken: self.broken + other.broken,
        }
    }
}

/// s(β) = 1 − 0.78 β: what the softening length of a section is scaled by, whose crack opens in
/// bending by the share β (F80).
#[must_use]
pub fn bending_scale(bending_share: f64) -> f64 {
    1.0 - BENDING_RELIEF * bending_share
}

impl SectionLaw {
    /// Of a material, with five stations and damage that takes at least four steps to grow.
    #[must_use]
    pub fn new(material: &Material) -> Self {
        Self {
            elastic: PlaneStress::new(material.young, material.poisson),
            material: *material,
            stations: lobatto(STATIONS),
            most_growth: MOST_GROWTH,
            most_strain: MOST_STRAIN,
            hardening: None,
            soft: None,
        }
    }

    /// The same of a metal, which yields and does not crack.
    #[must_use]
    pub fn yielding(self, hardening: Hardening) -> Self {
        Self { stations: gauss(YIELDING_STATIONS), hardening: Some(hardening), ..self }
    }

    /// The greatest principal stress below which a point is elastic \[Pa\]; of what yields, by how
    /// much von Mises' stress may change until it may flow. None where that alone does not tell.
    #[must_use]
    pub fn elastic_limit(&self, state: &PointState) -> Option<f64> {
        if self.soft.is_some() {
            return self.soft_limit(state);
        }
        match self.hardening {
            Some(hardening) if state.flow.is_empty() => Some(hardening.yield_stress),
            Some(_) => state.last.is_none().then_some(state.slack),
            None => state.crack.is_none().then(|| state.in_force(0.0)),
        }
    }

    /// H of c = (1 + H)(1 − σ_f/σ̄) is x/(1 − x), for a strength σ_f in force \[Pa\], a softening
    /// length l_c \[m\] and a share of bending β \[1\]; x = s(β)σ_f²l_c/(2fG_f).
    #[must_use]
    pub fn softening(&self, strength: f64, length: f64, bending_share: f64) -> f64 {
        let toughness = 2.0 * self.elastic.modulus * self.material.fracture_energy;
        let x = bending_scale(bending_share) * strength * strength * length / toughness;
        let x = x.min(MOST_BRITTLE);
        x / (1.0 - x)
    }
}
