//! What becomes of a body that stays one, and how points carry its surface.

use super::components::BondedParts;
use super::state::{NO_CHANGE, Peridynamics};
use crate::solver::body::PressedDomain;
use cullet_fragment::carriers::Carriers;
use cullet_fragment::motion;
use cullet_fragment::reshaped::{Reshaped, reshaped};
use cullet_fragment::straightened::Straightened;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::shapes::refine_solid;
use cullet_geometry::{Mat3, Sheet, Solid, Vec3};
use cullet_model::{Deformation, Failure, Fragment, FragmentOrigin, Fragmentation, SolveOutcome};
use rayon::prelude::*;

/// Share of the energy of the hits that must have gone into flow for a new shape \[1\].
const LEAST_DENT: f64 = 1e-2;

/// How far a place must have moved for that, in points' distances.
pub(super) const LEAST_MOVE: f64 = 0.04;

/// Longest edge of the new surface, in points' distances.
const FINE: f64 = 1.5;

/// Change of volume above which it is worth a word \[1\].
const SWOLLEN: f64 = 0.01;

/// Fewest points that carry a surface.
const FEW: usize = 8;

/// Points that carry a surface along, each with the deformation around it.
#[derive(Debug)]
pub(super) struct CarriedShape {
    carriers: Carriers,
    straight: Straightened,
    first: Vec<Vec3>,
    now: Vec<Vec3>,
    gradients: Vec<Mat3>,
    spacing: f64,
    /// How far the one that moved most has, beside the motion of the whole \[m\].
    pub(super) moved: f64,
}

impl CarriedShape {
    /// Of some points, those that have lost half of their bonds aside.
    pub(super) fn of(body: &PressedDomain, points: &[usize], spacing: f64) -> Option<Self> {
        let gradient = |&p: &usize| Some((p, body.domain.gradient(p)?));
        let all: Vec<(usize, Mat3)> = points.par_iter().filter_map(gradient).collect();
        if all.len() < FEW {
            return None;
        }
        let first: Vec<Vec3> = all.iter().map(|(p, _)| body.first[*p]).collect();
        let now: Vec<Vec3> = all.iter().map(|(p, _)| body.domain.places[*p]).collect();
        let masses: Vec<f64> = all.iter().map(|(p, _)| body.domain.mass(*p)).collect();
        let straight = Straightened::of(&masses, &first, &now);
        let far = |(x, y): (&Vec3, &Vec3)| (straight.place(y) - x).norm();
        let moved = first.iter().zip(&now).map(far).fold(0.0, f64::max);
        let carriers = Carriers::new(first.clone(), 2.0 * spacing);
        let gradients = all.into_iter().map(|one| one.1).collect();
        Some(Self { carriers, straight, first, now, gradients, spacing, moved })
    }

    /// A solid where its points are now, as large as it was, and by which share it was larger.
    pub(super) fn bent(&self, solid: &Solid) -> Result<Reshaped, Failure> {
        let volume = solid.mesh.signed_volume();
        let solid = refine_solid(solid, FINE * self.spacing)
            .map_err(|error| Failure::Cut(error.to_string()))?;
        let carry = |vertex: &Vec3| {
            let shares = self.carriers.shares(vertex).into_iter();
            let now = shares.map(|(p, share)| {
                (self.now[p] + self.gradients[p] * (vertex - self.first[p])) * share
            });
            self.straight.place(&now.sum())
        };
        let now = solid.mesh.vertices.par_iter().map(carry).collect();
        reshaped(solid, now, volume)
            .ok_or_else(|| Failure::Cut("the new shape is turned inside out".to_owned()))
    }
}

impl Peridynamics {
    /// Whether enough has flowed for a dent.
    pub(super) fn is_dented(&self) -> bool {
        self.record.plastic > LEAST_DENT * self.energy()
    }

    /// Momentum \[kg·m/s\] and angular momentum about its middle \[kg·m²/s\] that the body has.
    pub(super) fn given(&self) -> [Vec3; 2] {
        let (domain, masses) = (&self.body.domain, self.body.masses());
        let middle = domain.places.iter().zip(&masses).map(|(x, m)| x * *m).sum::<Vec3>();
        let middle = middle / masses.iter().sum::<f64>();
        if self.bonds.air_damping > 0.0 {
            // The air has taken some.
            let sums = domain.sums();
            return [sums.momentum, sums.angular - middle.cross(&sums.momentum)];
        }
        let momentum: Vec3 = self.presses().map(|it| it.given).sum();
        let moment: Vec3 = self.presses().map(|it| it.moment).sum();
        [momentum, moment - self.body.beside - middle.cross(&momentum)]
    }

    /// What comes of the hits.
    pub(super) fn finish(&mut self) -> Result<SolveOutcome, Failure> {
        self.check()?;
        let parts = BondedParts::of(&self.body.domain, self.setup.spacing);
        if parts.count > 1
            && let Some(broken) = self.broken(&parts)?
        {
            return Ok(broken);
        }
        self.one(&parts)
    }

    /// The body in its new shape; as it was, where that is the old one.
    fn one(&self, parts: &BondedParts) -> Result<SolveOutcome, Failure> {
        let all: Vec<usize> = (0..self.body.first.len()).filter(|&p| !parts.loose[p]).collect();
        let shape = CarriedShape::of(&self.body, &all, self.setup.spacing);
        let moved = shape.as_ref().map_or(0.0, |it| it.moved);
        let mut report = self.report().with("dent", "m", moved);
        let dented = self.is_dented() && moved > LEAST_MOVE * self.setup.spacing;
        let mut solid = (*self.problem.solid).clone();
        if let Some(shape) = shape.filter(|_| dented) {
            let Reshaped { solid: bent, swollen } = shape.bent(&solid)?;
            solid = bent;
            report = report.with("volume_change", "1", swollen);
            if swollen.abs() > SWOLLEN {
                report.warnings.push(format!(
                    "the volume changed by {swollen:+.3}: bonds lose volume where they flow"
                ));
            }
        }
        if self.record.broken > NO_CHANGE * self.energy() {
            report.warnings.push("cracks part nothing: they are not drawn".to_owned());
        }
        let fragment = Fragment {
            hulls: convex_parts(&solid, HullSettings::default()),
            solid,
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            sheet: Sheet::default(),
        };
        let mut fragments = vec![fragment];
        let [momentum, about] = self.given();
        motion::carry(&mut fragments, momentum, |_| about, self.problem.material.density);
        let reactions = self.supports.iter().map(|it| it.given.norm()).collect();
        if dented && let Some(Fragment { solid, hulls, velocity, spin, .. }) = fragments.pop() {
            let (body, work) = (solid.into(), self.record.plastic + self.record.broken);
            let made = Deformation { body, hulls, velocity, spin, work, reactions, report };
            return Ok(SolveOutcome::Deformed(Box::new(made)));
        }
        let origins = vec![FragmentOrigin::Solved];
        let whole =
            Fragmentation { fragments, origins, reactions, report, ..Fragmentation::default() };
        Ok(SolveOutcome::Unchanged(Box::new(whole)))
    }
}
