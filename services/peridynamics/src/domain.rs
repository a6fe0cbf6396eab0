//! A body of points and bonds, and its steps in time.

use crate::bonds::{BondError, BondGraph};
use crate::law::{BondBreaking, PeridynamicLaw};
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
    /// s_c of a bond between points whose bonds are whole; infinite where nothing breaks \[1\].
    pub critical: f64,
    /// What is left of each bond, k \[1\].
    pub left: Vec<f64>,
    /// e_p of each bond \[1\].
    flowed: Vec<f64>,
    /// V ∂W/∂q of each bond \[J\].
    pulls: Vec<f64>,
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
    /// Share of its bonds that is gone, φ = 1 − Σwk \[1\].
    pub damage: f64,
}

/// What the bonds of a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BondTally {
    /// Energy that flow took \[J\].
    pub plastic: f64,
    /// Energy that breaking took \[J\]; less than it should be, even negative, where bonds are
    /// drawn from pressed to broken in one step.
    pub broken: f64,
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
struct BondBlock<'a> {
    /// The first point.
    first: usize,
    states: &'a mut [MaterialPoint],
    left: &'a [f64],
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
        let reach = bonds.weights.iter().zip(&bonds.rest).map(|(w, l)| w * l).sum::<f64>();
        let reach = reach / points as f64;
        let critical = law
            .breaking
            .map_or(f64::INFINITY, |how| how.critical_stretch(law.bulk, law.shear, reach));
        Ok(Self {
            law,
            bonds,
            volumes,
            places,
            velocities: vec![Vec3::zeros(); points],
            forces: vec![Vec3::zeros(); points],
            states: vec![MaterialPoint::default(); points],
            critical,
            left: vec![1.0; number],
            flowed: vec![0.0; number],
            pulls: vec![0.0; number],
        })
    }

    /// Cuts the bonds between places \[m\] that `cuts` says: a notch. Both ends must say the same.
    pub fn sever(&mut self, cuts: impl Fn(&Vec3, &Vec3) -> bool) {
        for p in 0..self.places.len() {
            for b in self.bonds.of(p) {
                let other = &self.places[self.bonds.ends[b] as usize];
                if cuts(&self.places[p], other) {
                    self.left[b] = 0.0;
                }
            }
        }
    }

    /// Mass of a point \[kg\].
    #[must_use]
    pub fn mass(&self, point: usize) -> f64 {
        self.law.density * self.volumes[point]
    }

    /// A step that central differences bear \[s\]: the greatest ω² is no more than the greatest sum
    /// of a row of the stiffness over its mass (Gershgorin). By Cauchy and Schwarz W is at most
    /// ½ max(9K, 15μ) Σwkq², whatever has broken.
    #[must_use]
    pub fn stable_step(&self) -> f64 {
        let bonds = &self.bonds;
        let stiffness = (9.0 * self.law.bulk).max(15.0 * self.law.shear);
        let stretch = |b: usize| bonds.weights[b] / (bonds.rest[b] * bonds.rest[b]);
        let fastest = (0..self.places.len()).map(|p| {
            let both = |b: usize| {
                let (q, back) = (bonds.ends[b] as usize, bonds.back[b] as usize);
                self.volumes[p] * stretch(b) + self.volumes[q] * stretch(back)
            };
            2.0 * stiffness * bonds.of(p).map(both).sum::<f64>() / self.mass(p)
        });
        SAFETY * 2.0 / fastest.fold(0.0, f64::max).sqrt()
    }

    /// Softens bonds by their elastic stretch, the mean of both ends'; what was left of each before
    /// is kept in `pulls` until they are strained.
    fn soften(&mut self, breaking: &BondBreaking) {
        let bonds = &self.bonds;
        let (places, states, flowed) = (&self.places, &self.states, &self.flowed);
        self.pulls.copy_from_slice(&self.left);
        let critical = self.critical;
        let change = |p: usize| {
            bonds.of(p).map(move |b| {
                let (q, back) = (bonds.ends[b] as usize, bonds.back[b] as usize);
                let stretch = (places[q] - places[p]).norm() / bonds.rest[b] - 1.0;
                let elastic = stretch - 0.5 * (flowed[b] + flowed[back]);
                let damage = 0.5 * (states[p].damage + states[q].damage);
                breaking.left(elastic, critical * (1.0 + breaking.dust * damage))
            })
        };
        let found: Vec<f64> = (0..places.len()).into_par_iter().flat_map_iter(change).collect();
        self.left.iter_mut().zip(found).for_each(|(left, now)| *left = left.min(now));
    }

    /// Softens and strains the bonds, lets points flow, and finds the forces.
    pub fn strain(&mut self) -> BondTally {
        self.strain_after(0.0)
    }

    /// The same after a step of `dt` \[s\] with the velocities as they are.
    fn strain_after(&mut self, dt: f64) -> BondTally {
        match self.law.breaking {
            Some(breaking) => self.soften(&breaking),
            None => self.pulls.copy_from_slice(&self.left),
        }
        let tallies: Vec<BondTally> = {
            let (law, bonds) = (self.law, &self.bonds);
            let (places, volumes) = (&self.places, &self.volumes);
            let mut blocks = Vec::new();
            let (mut flowed, mut pulls) = (&mut self.flowed[..], &mut self.pulls[..]);
            let mut left = &self.left[..];
            for (k, states) in self.states.chunks_mut(BLOCK).enumerate() {
                let first = k * BLOCK;
                let number = bonds.of(first + states.len() - 1).end - bonds.of(first).start;
                let (some, rest) = flowed.split_at_mut(number);
                let (pull, others) = pulls.split_at_mut(number);
                let (own, after) = left.split_at(number);
                (flowed, pulls, left) = (rest, others, after);
                blocks.push(BondBlock { first, states, left: own, flowed: some, pulls: pull });
            }
            let moved = Moved { places, velocities: &self.velocities, dt };
            let step = |block: BondBlock<'_>| block.strain(&law, bonds, &moved, volumes);
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
            broken: sum.broken + more.broken,
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
        self.strain_after(dt)
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
            sum.elastic +=
                self.volumes[p] * self.law.energy(1.0 - state.damage, state.mean, state.deviation);
            sum.momentum += v * mass;
            sum.angular += self.places[p].cross(&v) * mass;
        }
        sum
    }
}

impl BondBlock<'_> {
    fn strain(
        self,
        law: &PeridynamicLaw,
        bonds: &BondGraph,
        moved: &Moved<'_>,
        volumes: &[f64],
    ) -> BondTally {
        let Self { first, states, left, flowed, pulls } = self;
        let origin = bonds.of(first).start;
        let mut tally = BondTally::default();
        let (mut extensions, mut earlier) = (Vec::new(), Vec::new());
        for (k, state) in states.iter_mut().enumerate() {
            let (point, range) = (first + k, bonds.of(first + k));
            let weights = &bonds.weights[range.clone()];
            let own = range.start - origin..range.end - origin;
            let (flowed, pulls) = (&mut flowed[own.clone()], &mut pulls[own.clone()]);
            extensions.clear();
            let elastic = |(b, flowed): (usize, &f64)| {
                let (one, two) = moved.lengths(point, bonds.ends[b] as usize);
                [one, two].map(|length| length / bonds.rest[b] - 1.0 - flowed)
            };
            extensions.extend(range.clone().zip(&*flowed).map(|bond| elastic(bond)[1]));
            let left = &left[own];
            let (whole, mean, mut deviation) = sums(weights, left, &extensions, &extensions);
            if pulls[..] != left[..] {
                earlier.clear();
                earlier.extend(range.zip(&*flowed).map(|bond| elastic(bond)[0]));
                let energy = |left: &[f64]| {
                    let (whole, mean, product) = sums(weights, left, &earlier, &extensions);
                    let other = sums(weights, left, &extensions, &extensions).1;
                    law.energy(whole, 1.0, 0.0) * mean * other + law.energy(0.0, 0.0, product)
                };
                // Central differences take the energy of what was and what is, not of either.
                tally.broken += volumes[point] * (energy(pulls) - energy(left));
            }
            let mut shrink = 1.0;
            let effective = if whole > 0.0 { deviation / whole } else { 0.0 };
            if let Some(yielded) = law.yields(effective, state.plastic) {
                shrink = yielded.left;
                deviation *= shrink * shrink;
                state.plastic += yielded.strain;
                tally.plastic += volumes[point] * whole * yielded.work;
                tally.yielding += 1;
            }
            for (b, pull) in pulls.iter_mut().enumerate() {
                let z = extensions[b] - mean;
                flowed[b] += (1.0 - shrink) * z;
                *pull = volumes[point] * weights[b] * left[b] * law.pull(mean, shrink * z);
            }
            (state.mean, state.deviation, state.damage) = (mean, deviation, 1.0 - whole);
        }
        tally
    }
}

/// Where points are, and how they came there.
struct Moved<'a> {
    places: &'a [Vec3],
    velocities: &'a [Vec3],
    dt: f64,
}

impl Moved<'_> {
    /// How far two points were from each other before the last step, and are.
    fn lengths(&self, one: usize, two: usize) -> (f64, f64) {
        let apart = self.places[two] - self.places[one];
        let before = apart - (self.velocities[two] - self.velocities[one]) * self.dt;
        (before.norm(), apart.norm())
    }
}

/// Of a point's bonds with the extensions x and y: Σwk, x̄ = Σwkx/Σwk, and Σwk(x − x̄)(y − ȳ).
fn sums(weights: &[f64], left: &[f64], x: &[f64], y: &[f64]) -> (f64, f64, f64) {
    let share = || weights.iter().zip(left).map(|(w, k)| w * k);
    let whole: f64 = share().sum();
    if whole <= 0.0 {
        return (0.0, 0.0, 0.0);
    }
    let mean = |x: &[f64]| share().zip(x).map(|(s, x)| s * x).sum::<f64>() / whole;
    let (one, two) = (mean(x), mean(y));
    let product = share().zip(x.iter().zip(y)).map(|(s, (x, y))| s * (x - one) * (y - two));
    (whole, one, product.sum())
}
