//! What becomes of a body that has flowed: the shape that is left, and what is reported of it.

use super::torn::{FINE, TornShape};
use super::{Ductile, THINNEST};
use cullet_fragment::carriers::Carriers;
use cullet_fragment::motion;
use cullet_fragment::press::PressShape;
use cullet_fragment::reshaped::{Reshaped, reshaped};
use cullet_fragment::straightened::Straightened;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::shapes::refine_solid;
use cullet_geometry::{Mat3, Sheet, Vec3};
use cullet_model::outcome::DELIVERED_IMPULSE;
use cullet_model::{
    Deformation, Failure, Fragment, FragmentOrigin, Fragmentation, Report, SolveOutcome, Solver,
};
use rayon::prelude::*;

/// Share of a cell that a place must have moved for good to be worth a new shape, and of the energy
/// of the hits that must have gone into that \[1\].
const LEAST_DENT: (f64, f64) = (0.02, 1e-2);

/// Change of volume above which it is worth a word \[1\]: J2 keeps it to 0.1 %.
const SWOLLEN: f64 = 0.01;

/// Fewest cells across the radius of a dent that is resolved.
const RESOLVED: f64 = 1.5;

/// Mean pressure under a ball over the yield stress, where all around it flows \[Tabor 1951\].
const HARDNESS: f64 = 3.0;

impl Ductile {
    /// Whether enough has flowed for a dent.
    pub(super) fn is_dented(&self) -> bool {
        self.record.plastic > LEAST_DENT.1 * self.energy()
    }

    /// The body in its new shape; as it was, where that is the old one.
    pub(super) fn finish(&mut self) -> Result<SolveOutcome, Failure> {
        self.check()?;
        let (first, now) = self.node_places();
        let motions = self.domain.motions();
        let straight = match self.record.broken {
            0 => Straightened::of(&self.domain.grid.nodes.mass, &first, &now),
            _ => self.largest_stays(&motions),
        };
        let places = &self.domain.particles.reference;
        let moved = |p: usize| straight.place(&(places[p] + motions[p].displacement)) - places[p];
        let deepest = (0..places.len()).map(|p| moved(p).norm()).fold(0.0, f64::max);
        let strain = self.domain.particles.flow.iter().map(|it| it.history.strain);
        let strain = strain.fold(0.0, f64::max);
        let mut report = self.report().with("greatest_plastic_strain", "1", strain);
        if self.record.broken == 0 {
            report = report.with("dent", "m", deepest);
        }
        let spacing = self.domain.grid.spacing.max();
        let mut dented = self.is_dented() && deepest > LEAST_DENT.0 * spacing;
        let mut solid = (*self.problem.solid).clone();
        if self.record.broken > 0 {
            let carried = TornShape::new(self, &straight, &motions);
            let mut torn = carried.parts()?;
            if torn.are_several() {
                return Ok(SolveOutcome::Broken(Box::new(carried.broken(torn, report))));
            }
            report.warnings.append(&mut torn.warnings);
            dented = true;
            solid = torn.only().unwrap_or(solid);
        } else if dented {
            let Reshaped { solid: bent, swollen } = self.bent(&straight)?;
            solid = bent;
            report = report.with("volume_change", "1", swollen);
            if swollen.abs() > SWOLLEN {
                report.warnings.push(format!(
                    "the volume changed by {swollen:+.3}: flow keeps it, so the grid is too coarse \
                     for this shape (F102)"
                ));
            }
        }
        let fragment = Fragment {
            hulls: convex_parts(&solid, HullSettings::default()),
            solid,
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            sheet: Sheet::default(),
        };
        let mut fragments = vec![fragment];
        let (momentum, moment) = self.given();
        motion::carry(&mut fragments, momentum, |_| moment, self.problem.material.density);
        let reactions = self.reactions();
        let work = self.record.plastic + self.record.torn;
        if dented && let Some(Fragment { solid, hulls, velocity, spin, .. }) = fragments.pop() {
            let body = solid.into();
            let made = Deformation { body, hulls, velocity, spin, work, reactions, report };
            return Ok(SolveOutcome::Deformed(Box::new(made)));
        }
        let origins = vec![FragmentOrigin::Solved];
        let whole =
            Fragmentation { fragments, origins, reactions, report, ..Fragmentation::default() };
        Ok(SolveOutcome::Unchanged(Box::new(whole)))
    }

    /// What was given to the body \[N·s\], and its moment about the middle of the body as it moves
    /// \[N·m·s\]: what presses moves along the surface.
    pub(super) fn given(&self) -> (Vec3, Vec3) {
        let momentum: Vec3 = self.presses().map(|it| it.given).sum();
        let moment: Vec3 = self.presses().map(|it| it.moment).sum();
        let (_, now) = self.node_places();
        let masses = &self.domain.grid.nodes.mass;
        let middle = now.iter().zip(masses).map(|(x, m)| x * *m).sum::<Vec3>();
        let middle = middle / masses.iter().sum::<f64>();
        (momentum, moment - middle.cross(&momentum))
    }

    /// Impulse that each support gave \[N·s\].
    pub(super) fn reactions(&self) -> Vec<f64> {
        self.supports.iter().map(|it| it.given.norm()).collect()
    }

    /// The solid where its points are now, as large as it was, and by which share it was larger.
    fn bent(&self, straight: &Straightened) -> Result<Reshaped, Failure> {
        let spacing = self.domain.grid.spacing.max();
        let solid = refine_solid(&self.problem.solid, FINE * spacing)
            .map_err(|error| Failure::Cut(error.to_string()))?;
        let places = &self.domain.particles.reference;
        let carriers = Carriers::new(places.clone(), spacing);
        let motions = self.domain.motions();
        let carry = |vertex: &Vec3| {
            let mut sum = Vec3::zeros();
            for (p, share) in carriers.shares(vertex) {
                let gradient = Mat3::identity() + motions[p].displacement_gradient;
                let now = places[p] + motions[p].displacement + gradient * (vertex - places[p]);
                sum += now * share;
            }
            straight.place(&sum)
        };
        let now = solid.mesh.vertices.par_iter().map(carry).collect();
        let volume = self.problem.solid.mesh.signed_volume();
        reshaped(solid, now, volume)
            .ok_or_else(|| Failure::Cut("the new shape is turned inside out".to_owned()))
    }

    /// What is known before the first step.
    pub(super) fn first_warnings(&self) -> Vec<String> {
        let spacing = self.points.spacing;
        let hits = self.problem.impacts.iter().zip(&self.strikers);
        let narrow = hits.filter_map(|(hit, striker)| {
            let PressShape::Ball(radius) = striker.shape else { return None };
            // E = ∫ 3σ_y πa² dδ with a² = 2Rδ
            let pi = std::f64::consts::PI;
            let hardness = HARDNESS * self.flow.hardening.yield_stress;
            let dent = (4.0 * radius * hit.energy / (pi * hardness)).sqrt().sqrt();
            (dent < RESOLVED * spacing).then(|| {
                format!(
                    "the dent is about {dent:.2e} m in radius, less than {RESOLVED} cells of \
                     {spacing:.2e} m: it comes out too shallow and too wide (F101)"
                )
            })
        });
        narrow.collect()
    }

    fn report(&self) -> Report {
        let delivered = self.strikers.iter().zip(&self.problem.impacts);
        let delivered: f64 = delivered.map(|(it, hit)| it.given.dot(&hit.normal)).sum();
        let crushed = self.presses().map(|it| it.crushed).sum();
        let mut report = Report {
            solver: Self::NAME.to_owned(),
            spacing: self.domain.grid.spacing.max(),
            particles: self.domain.particles.len() as u64,
            steps: self.domain.steps,
            simulated: self.domain.time,
            dissipated_energy: self.record.plastic,
            warnings: self.record.warnings.clone(),
            ..Report::default()
        }
        .with(DELIVERED_IMPULSE, "N·s", delivered)
        .with("plastic_work", "J", self.record.plastic)
        .with("torn_points", "1", f64::from(self.record.broken))
        .with("energy_of_tears", "J", self.record.torn)
        .with("energy_of_collisions", "J", self.record.collided)
        .with("vibration", "J", self.settling.taken())
        .with("energy_balance", "1", 1.0 + self.record.balance.off)
        .with("energy_of_crushed_contact", "J", crushed);
        report.warnings.extend(self.record.balance.tell());
        if self.record.thinnest > THINNEST {
            report.warnings.push(format!(
                "a point was pressed to {:.3} of its thickness: beyond {:.2} the weights of the \
                 body at rest do not hold (F103)",
                1.0 / self.record.thinnest.sqrt(),
                1.0 / THINNEST.sqrt()
            ));
        }
        if self.record.shredded > 0 {
            report.warnings.push(format!(
                "{} of {} torn points were drawn out farther than the grid follows: they tore for \
                 that, whatever their law",
                self.record.shredded, self.record.broken
            ));
        }
        if self.record.crushed > 0 {
            report.warnings.push(format!(
                "crushed: {} points were at J = 0.2 at one time (F07)",
                self.record.crushed
            ));
        }
        report
    }
}
