//! A body of points and bonds, and its steps in time.

pub(crate) mod contact;
mod damping;
pub(crate) mod limits;
mod parts;
mod strain;
mod sums;

use crate::anisotropy::isotropic;
use crate::bonds::{BondError, BondGraph, BondSlot};
use crate::law::PeridynamicLaw;
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;
use cullet_simd::{LANES, Lanes, PackedRecord, SimdLevel, WINDOW};
pub use limits::StrainLimit;
use nalgebra::Rotation3;
use parts::MovingParts;
use rayon::prelude::*;
pub use strain::BondTally;
pub use sums::BodySum;

/// Share of the bound on the step that is taken.
const SAFETY: f64 = 0.7;

/// A body in the middle of its motion.
#[derive(Clone, Debug)]
pub struct PeridynamicDomain {
    /// What it is made of.
    pub law: PeridynamicLaw,
    /// Its bonds.
    pub bonds: BondGraph,
    /// V of each point \[m³\].
    pub volumes: Vec<f64>,
    /// Where each is \[m\].
    pub places: Vec<Vec3>,
    /// How it moves \[m/s\].
    pub velocities: Vec<Vec3>,
    /// Force on each \[N\].
    pub forces: Vec<Vec3>,
    /// State of each.
    pub states: Vec<MaterialPoint>,
    /// s_c of a bond between points whose bonds are whole; infinite where nothing breaks \[1\].
    pub critical: f64,
    /// Points that are the body's own: those behind them are images of it, which are in no sum.
    pub own: usize,
    /// Instructions of the processor that it is worked out with.
    pub level: SimdLevel,
    /// Of dashpots on each point in the last step \[N\]; empty where there are none.
    pub(crate) drags: Vec<Vec3>,
    /// δ \[m\].
    pub(crate) horizon: f64,
    /// Mean of `volumes` \[m³\].
    mean_volume: f64,
    /// Places at rest, about their mean \[m\].
    pub(crate) reference: Vec<Vec3>,
    /// Greatest sum over a point's bonds of both ends' wV/l₀², over its own V \[1/m²\].
    steepest: f64,
    /// What points that touch hold \[J\].
    contact: f64,
    /// How the body is turned.
    turn: Rotation3<f64>,
    /// Points that move as a whole of their own: displacements are counted from each. Empty where
    /// the body is one.
    parts: MovingParts,
    /// Σw of each point over the mean volume, as the kernel sums it up \[1\].
    totals: Vec<f32>,
    /// What the kernel reads of each point, and a window of none behind them.
    records: Vec<PackedRecord>,
    /// k of each bond; empty while all are whole and nothing may break \[1\].
    pub(crate) left: Vec<Lanes<f32>>,
    /// e_p of each bond, then the other end's; empty where nothing may flow \[1\].
    pub(crate) flowed: [Vec<Lanes<f32>>; 2],
    /// Strength of each point over that of the law; empty where all have that \[1\].
    strengths: Vec<f32>,
}

/// What a point carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialPoint {
    /// q̄, over the bonds that are left \[1\].
    pub mean: f64,
    /// Σwkz² \[1\].
    pub deviation: f64,
    /// ε_p \[1\].
    pub plastic: f64,
    /// D = ΣΔε_p/ε_f of [`cullet_model::DuctileFailure`] \[1\].
    pub ductile: f64,
    /// Share of its bonds that is gone, φ = 1 − Σwk \[1\].
    pub damage: f64,
}

impl PeridynamicDomain {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let vectors = [&self.places, &self.velocities, &self.forces, &self.drags];
        let vectors = vectors.map(|list| held(list)).iter().sum::<u64>();
        self.bonds.bytes() + vectors + held(&self.volumes) + held(&self.states)
    }

    /// Points at rest, those within `horizon` \[m\] of each other bonded. Places are rounded to
    /// f32 in horizons about the middle of the body. Points whose numbers are near should be near:
    /// the kernel reads neighbours from where they lie.
    ///
    /// # Errors
    ///
    /// If they cannot be bonded, or a number of the law does not hold.
    pub fn new(
        places: Vec<Vec3>,
        volumes: Vec<f64>,
        horizon: f64,
        law: PeridynamicLaw,
    ) -> Result<Self, BondError> {
        law.check()?;
        let (low, high) = places
            .iter()
            .fold((places.first().copied().unwrap_or_default(), Vec3::repeat(f64::MIN)), |b, x| {
                (b.0.inf(x), b.1.sup(x))
            });
        let middle = 0.5 * (low + high);
        let packed = |x: &Vec3| ((x - middle) / horizon).map(|c| c as f32);
        let mut records: Vec<PackedRecord> = places
            .iter()
            .map(packed)
            .map(|x| PackedRecord([x.x, x.y, x.z, 0.0, 0.0, 0.0, 0.0, 0.0]))
            .collect();
        records.resize(places.len() + WINDOW, PackedRecord::default());
        let rounded = |x: &Vec3| packed(x).map(f64::from) * horizon;
        let about: Vec<Vec3> = places.iter().map(rounded).collect();
        let places: Vec<Vec3> = about.iter().map(|x| x + middle).collect();
        let moments = law.anisotropy.map_or_else(isotropic, |how| how.quartic);
        let bonds = BondGraph::with_moments(&places, &volumes, horizon, &moments)?;
        let points = places.len();
        let mean = about.iter().sum::<Vec3>() / points as f64;
        let mut body = Self {
            law,
            volumes,
            velocities: vec![Vec3::zeros(); points],
            forces: vec![Vec3::zeros(); points],
            states: vec![MaterialPoint::default(); points],
            critical: f64::INFINITY,
            own: points,
            level: SimdLevel::best(),
            horizon,
            mean_volume: 0.0,
            steepest: 0.0,
            contact: 0.0,
            reference: about.iter().map(|x| x - mean).collect(),
            turn: Rotation3::identity(),
            parts: MovingParts::default(),
            drags: Vec::new(),
            totals: (0..points).map(|p| bonds.total(p)).collect(),
            records,
            left: Vec::new(),
            flowed: [Vec::new(), Vec::new()],
            strengths: Vec::new(),
            places,
            bonds,
        };
        body.mean_volume = body.volumes.iter().sum::<f64>() / points as f64;
        body.steepest = body.steepest_row();
        if let Some(how) = law.breaking {
            body.critical = how.critical_stretch(law.bulk, law.shear, body.reach());
        }
        Ok(body)
    }

    fn steepest_row(&self) -> f64 {
        let both = |p: usize, b: BondSlot| {
            let weights = b.of(&self.bonds.weights) + b.of(&self.bonds.back_weights);
            f64::from(weights) * self.mean_volume / self.rest(p, b).powi(2)
        };
        let row = |p: usize| self.bonds.of(p).map(|b| both(p, b)).sum::<f64>() / self.volumes[p];
        (0..self.places.len()).map(row).fold(0.0, f64::max)
    }

    /// Mean of Σwl₀ \[m\].
    pub(crate) fn reach(&self) -> f64 {
        let of = |p: usize| {
            let bonds = self.bonds.of(p);
            let sum: f64 =
                bonds.map(|b| f64::from(b.of(&self.bonds.weights)) * self.rest(p, b)).sum();
            sum / f64::from(self.totals[p])
        };
        (0..self.places.len()).map(of).sum::<f64>() / self.places.len() as f64
    }

    /// l₀ of a bond of a point \[m\].
    #[must_use]
    pub fn rest(&self, point: usize, bond: BondSlot) -> f64 {
        (self.reference[bond.end] - self.reference[point]).norm()
    }

    /// What is left of a bond, k \[1\].
    #[must_use]
    pub fn left(&self, bond: BondSlot) -> f64 {
        if self.left.is_empty() { 1.0 } else { f64::from(bond.of(&self.left)) }
    }

    /// Cuts the bonds between places \[m\] that `cuts` says: a notch. Both ends must say the same.
    pub fn sever(&mut self, cuts: impl Fn(&Vec3, &Vec3) -> bool) {
        self.make_room(true, false);
        for p in 0..self.places.len() {
            for bond in self.bonds.of(p) {
                if cuts(&self.places[p], &self.places[bond.end]) {
                    self.left[bond.group].0[bond.lane] = 0.0;
                }
            }
        }
    }

    /// Makes points stronger or weaker by `factors`: a bond's s_c is multiplied by the lesser of
    /// those of its ends \[1\].
    pub fn strengthen(&mut self, factors: &[f64]) {
        let varies = factors.len() == self.places.len() && factors.iter().any(|&x| x != 1.0);
        self.strengths = match varies {
            true => factors.iter().map(|&x| x as f32).collect(),
            false => Vec::new(),
        };
    }

    /// Makes the lists that bonds which break or flow need.
    pub(crate) fn make_room(&mut self, breaks: bool, flows: bool) {
        let groups = self.bonds.ends.len();
        if breaks && self.left.is_empty() {
            self.left = vec![Lanes([1.0; LANES]); groups];
        }
        if flows && self.flowed[0].is_empty() {
            self.flowed = [0, 1].map(|_| vec![Lanes([0.0; LANES]); groups]);
        }
    }

    /// Mass of a point \[kg\].
    #[must_use]
    pub fn mass(&self, point: usize) -> f64 {
        self.law.density * self.volumes[point]
    }

    /// The step that central differences bear \[s\]: the greatest ω² is no more than the greatest
    /// sum of a row of the stiffness over its mass (Gershgorin). By Cauchy and Schwarz W is at most
    /// ½ max(9K, 15μ) Σwkq², whatever has broken. Dashpots make it shorter.
    #[must_use]
    pub fn greatest_step(&self) -> f64 {
        let share = self.law.damping.bonds;
        2.0 / self.fastest() * ((1.0 + share * share).sqrt() - share)
    }

    /// A step with a margin to [`PeridynamicDomain::greatest_step`] \[s\].
    #[must_use]
    pub fn stable_step(&self) -> f64 {
        SAFETY * self.greatest_step()
    }

    /// A step of `dt` \[s\] by central differences; `hold` has the last word on velocities. Forces
    /// are those of [`PeridynamicDomain::strain`], which ends it.
    pub fn advance(&mut self, dt: f64, hold: impl Fn(usize, Vec3) -> Vec3 + Sync) -> BondTally {
        let (density, volumes, forces) = (self.law.density, &self.volumes, &self.forces);
        let faster = |(p, v): (usize, &mut Vec3)| *v += forces[p] * (dt / (density * volumes[p]));
        self.velocities.par_iter_mut().enumerate().for_each(faster);
        let air = if self.law.damping.air > 0.0 { self.slow(dt) } else { 0.0 };
        let both = self.places.par_iter_mut().zip(self.velocities.par_iter_mut());
        both.enumerate().for_each(|(p, (x, v))| {
            *v = hold(p, *v);
            *x += *v * dt;
        });
        let mut tally = self.strain_after(dt);
        tally.damped += air;
        tally
    }
}
