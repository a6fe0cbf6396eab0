//! A body of points and bonds, and its steps in time.

use crate::bonds::{BondError, BondGraph};
use crate::law::PeridynamicLaw;
use cullet_geometry::{Mat3, Vec3};
use rayon::prelude::*;

/// Share of the bound on the step that is taken.
const SAFETY: f64 = 0.7;

/// Points whose bonds are looked at together.
const BLOCK: usize = 256;

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
    /// e_p of each bond \[1\].
    flowed: Vec<f64>,
    /// V ∂W/∂q of each bond \[J\].
    pulls: Vec<f64>,
}

/// What a point carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialPoint {
    /// q̄ \[1\].
    pub mean: f64,
    /// Σwz² \[1\].
    pub deviation: f64,
    /// ε_p \[1\].
    pub plastic: f64,
}

/// What the bonds of a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BondTally {
    /// Energy that flow took \[J\].
    pub plastic: f64,
    /// Points that flowed.
    pub yielding: usize,
}

/// Sums over a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodySum {
    /// \[J\].
    pub kinetic: f64,
    /// \[J\].
    pub elastic: f64,
    /// \[kg m/s\].
    pub momentum: Vec3,
    /// About the origin \[kg m²/s\].
    pub angular: Vec3,
}

/// Some points and their bonds.
struct Block<'a> {
    /// The first point.
    first: usize,
    states: &'a mut [MaterialPoint],
    flowed: &'a mut [f64],
    pulls: &'a mut [f64],
}

impl PeridynamicDomain {
    /// Points at rest, those within `horizon` \[m\] of each other bonded.
    ///
    /// # Errors
    ///
    /// If they cannot be bonded.
    pub fn new(
        places: Vec<Vec3>,
        volumes: Vec<f64>,
        horizon: f64,
        law: PeridynamicLaw,
    ) -> Result<Self, BondError> {
        let bonds = BondGraph::new(&places, &volumes, horizon)?;
        let (points, number) = (places.len(), bonds.ends.len());
        Ok(Self {
            law,
            bonds,
            volumes,
            places,
            velocities: vec![Vec3::zeros(); points],
            forces: vec![Vec3::zeros(); points],
            states: vec![MaterialPoint::default(); points],
            flowed: vec![0.0; number],
            pulls: vec![0.0; number],
        })
    }

    /// Mass of a point \[kg\].
    #[must_use]
    pub fn mass(&self, point: usize) -> f64 {
        self.law.density * self.volumes[point]
    }

    /// A step that central differences bear \[s\]: the greatest ω² is no more than the greatest sum
    /// of a row of the stiffness over its mass (Gershgorin). W is ½(9K − 15μ)q̄² + 15/2 μ Σwq² at
    /// rest; the first part, if it is positive, hardly moves a point that has bonds all round.
    #[must_use]
    pub fn stable_step(&self) -> f64 {
        let bonds = &self.bonds;
        let bulk = (9.0 * self.law.bulk - 15.0 * self.law.shear).max(0.0);
        // Of a point: |Σ wn/l₀| and Σ w/l₀ + |Σ wn/l₀|, its own row and those of its other ends.
        let sums: Vec<[f64; 2]> = (0..self.places.len())
            .map(|p| {
                let (mut all, mut net) = (0.0, Vec3::zeros());
                for b in bonds.of(p) {
                    let along = self.places[bonds.ends[b] as usize] - self.places[p];
                    let share = bonds.weights[b] / bonds.rest[b];
                    all += share;
                    net += along * (share / along.norm());
                }
                [net.norm(), all + net.norm()]
            })
            .collect();
        let stretch = |b: usize| bonds.weights[b] / (bonds.rest[b] * bonds.rest[b]);
        let fastest = (0..self.places.len()).map(|p| {
            let [net, all] = sums[p];
            let bonded: f64 = bonds.of(p).map(stretch).sum();
            let own = self.volumes[p] * (bulk * net * all + 30.0 * self.law.shear * bonded);
            let others = bonds.of(p).map(|b| {
                let (q, back) = (bonds.ends[b] as usize, bonds.back[b] as usize);
                let share = bulk * bonds.weights[back] / bonds.rest[back] * sums[q][1];
                self.volumes[q] * (share + 30.0 * self.law.shear * stretch(back))
            });
            (own + others.sum::<f64>()) / self.mass(p)
        });
        SAFETY * 2.0 / fastest.fold(0.0, f64::max).sqrt()
    }

    /// Strains the bonds, lets points flow, and finds the forces.
    pub fn strain(&mut self) -> BondTally {
        let tallies: Vec<BondTally> = {
            let (law, bonds) = (self.law, &self.bonds);
            let (places, volumes) = (&self.places, &self.volumes);
            let mut blocks = Vec::new();
            let (mut flowed, mut pulls) = (&mut self.flowed[..], &mut self.pulls[..]);
            for (k, states) in self.states.chunks_mut(BLOCK).enumerate() {
                let first = k * BLOCK;
                let number = bonds.of(first + states.len() - 1).end - bonds.of(first).start;
                let (some, rest) = flowed.split_at_mut(number);
                let (pull, others) = pulls.split_at_mut(number);
                (flowed, pulls) = (rest, others);
                blocks.push(Block { first, states, flowed: some, pulls: pull });
            }
            let step = |block: Block<'_>| block.strain(&law, bonds, places, volumes);
            blocks.into_par_iter().map(step).collect()
        };
        let bonds = &self.bonds;
        let force = |p: usize| {
            bonds.of(p).fold(Vec3::zeros(), |force, b| {
                let along = self.places[bonds.ends[b] as usize] - self.places[p];
                let both = self.pulls[b] + self.pulls[bonds.back[b] as usize];
                force + along * (both / (bonds.rest[b] * along.norm()))
            })
        };
        self.forces = (0..self.places.len()).into_par_iter().map(force).collect();
        tallies.into_iter().fold(BondTally::default(), |sum, more| BondTally {
            plastic: sum.plastic + more.plastic,
            yielding: sum.yielding + more.yielding,
        })
    }

    /// A step of `dt` \[s\] by central differences; `hold` has the last word on velocities. Forces
    /// are those of [`PeridynamicDomain::strain`], which ends it.
    pub fn advance(&mut self, dt: f64, hold: impl Fn(usize, Vec3) -> Vec3 + Sync) -> BondTally {
        let (law, volumes, forces) = (self.law, &self.volumes, &self.forces);
        let move_on = |(p, (x, v)): (usize, (&mut Vec3, &mut Vec3))| {
            *v = hold(p, *v + forces[p] * (dt / (law.density * volumes[p])));
            *x += *v * dt;
        };
        let both = self.places.par_iter_mut().zip(self.velocities.par_iter_mut());
        both.enumerate().for_each(move_on);
        self.strain()
    }

    /// Cauchy's stress at a point for small strains, Σw (∂W/∂q/w) n⊗n \[Pa\].
    #[must_use]
    pub fn stress(&self, point: usize) -> Mat3 {
        self.bonds.of(point).fold(Mat3::zeros(), |sum, b| {
            let along = self.places[self.bonds.ends[b] as usize] - self.places[point];
            let n = along / along.norm();
            sum + n * n.transpose() * (self.pulls[b] / self.volumes[point])
        })
    }

    /// Sums over the body.
    #[must_use]
    pub fn sums(&self) -> BodySum {
        let mut sum = BodySum::default();
        for (p, state) in self.states.iter().enumerate() {
            let (mass, v) = (self.mass(p), self.velocities[p]);
            sum.kinetic += 0.5 * mass * v.norm_squared();
            sum.elastic += self.volumes[p] * self.law.energy(state.mean, state.deviation);
            sum.momentum += v * mass;
            sum.angular += self.places[p].cross(&v) * mass;
        }
        sum
    }
}

impl Block<'_> {
    fn strain(
        self,
        law: &PeridynamicLaw,
        bonds: &BondGraph,
        places: &[Vec3],
        volumes: &[f64],
    ) -> BondTally {
        let Self { first, states, flowed, pulls } = self;
        let origin = bonds.of(first).start;
        let mut tally = BondTally::default();
        for (k, state) in states.iter_mut().enumerate() {
            let (point, range) = (first + k, bonds.of(first + k));
            let weights = &bonds.weights[range.clone()];
            let (ends, rest) = (&bonds.ends[range.clone()], &bonds.rest[range.clone()]);
            let own = range.start - origin..range.end - origin;
            let (flowed, pulls) = (&mut flowed[own.clone()], &mut pulls[own]);
            let mut mean = 0.0;
            for (b, q) in pulls.iter_mut().enumerate() {
                let length = (places[ends[b] as usize] - places[point]).norm();
                *q = length / rest[b] - 1.0;
                mean += weights[b] * *q;
            }
            let mut deviation = 0.0;
            for (b, q) in pulls.iter_mut().enumerate() {
                *q -= mean + flowed[b];
                deviation += weights[b] * *q * *q;
            }
            if let Some(yielded) = law.yields(deviation, state.plastic) {
                for (z, flowed) in pulls.iter_mut().zip(flowed.iter_mut()) {
                    *flowed += (1.0 - yielded.left) * *z;
                    *z *= yielded.left;
                }
                deviation *= yielded.left * yielded.left;
                state.plastic += yielded.strain;
                tally.plastic += volumes[point] * yielded.work;
                tally.yielding += 1;
            }
            for (z, w) in pulls.iter_mut().zip(weights) {
                *z = volumes[point] * w * law.pull(mean, *z);
            }
            (state.mean, state.deviation) = (mean, deviation);
        }
        tally
    }
}
