//! The parts of a body that has broken: cut exactly where it was before the hit, and each bent as
//! its own points were.

use super::Peridynamics;
use super::components::BondedParts;
use super::shape::{CarriedShape, LEAST_MOVE};
use cullet_fragment::cut::{self, CutPart, CutSettings, DamageField, Partition};
use cullet_fragment::debris::{Mote, Motes};
use cullet_fragment::finish::{Finish, FinishedParts, FragmentMotion};
use cullet_fragment::pieces::Pieces;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::{Mat3, Vec3};
use cullet_model::{Failure, FragmentOrigin, Fragmentation, SolveOutcome};

/// Fewest points of a part that give it a spin and a shape of its own.
const FEW: usize = 8;

impl Peridynamics {
    /// The parts of the body; nothing where the cut leaves one.
    pub(super) fn broken(&mut self, parts: &BondedParts) -> Result<Option<SolveOutcome>, Failure> {
        let mut partition = self.cut(parts)?;
        if partition.parts.len() < 2 {
            return Ok(None);
        }
        let count = partition.parts.len();
        let of = &partition.particle_part;
        let own: Vec<Vec<usize>> = (0..count).map(|k| members(of, parts, k)).collect();
        let crumbled: Vec<bool> = (0..count).map(|k| is_heap(of, parts, k)).collect();
        let motions: Vec<FragmentMotion> = own.iter().map(|all| self.motion(all)).collect();
        let mut bent = 0;
        for (part, all) in partition.parts.iter_mut().zip(&own) {
            if self.record.plastic > 0.0 && all.len() >= FEW {
                bent += usize::from(self.bend(part, all)?);
            }
        }
        let [momentum, about] = self.given();
        let cell = 2.0 * self.setup.spacing;
        let finish = Finish {
            problem: &self.problem,
            spacing: (cell, cell),
            motes: &self.motes(parts),
            pushes: &[],
        };
        let FinishedParts { fragments, debris, warnings } =
            finish.carrying(partition.parts, &motions, &crumbled, [momentum, about]);
        let mut report = self.report().with("bent_parts", "1", bent as f64);
        report.crack_area = partition.crack_area;
        report.fracture_energy = self.problem.material.fracture_energy * partition.crack_area;
        report.warnings.extend(partition.warnings);
        report.warnings.extend(warnings);
        let reactions = self.supports.iter().map(|it| it.given.norm()).collect();
        let origins = vec![FragmentOrigin::Solved; fragments.len()];
        let found = Fragmentation { fragments, origins, debris, reactions, report };
        Ok(Some(SolveOutcome::Broken(Box::new(found))))
    }

    /// The body cut along the borders of its parts.
    fn cut(&self, parts: &BondedParts) -> Result<Partition, Failure> {
        let loose = parts.loose.iter().filter(|loose| **loose).count();
        let pieces = Pieces {
            of: parts.of.clone(),
            found: parts.count,
            crushed: loose as f64 / parts.loose.len() as f64,
            tolerance: self.problem.settings.tolerance(),
            ..Pieces::default()
        };
        let whether = |beside: &bool| f64::from(u8::from(*beside));
        let damage: Vec<f64> = parts.beside.iter().map(whether).collect();
        let end = self.body.clock.time;
        let when = |(beside, broke): (&bool, &f64)| {
            if *beside { broke.min(end) } else { f64::INFINITY }
        };
        let damage_time: Vec<f64> = parts.beside.iter().zip(&self.body.broke).map(when).collect();
        let field = DamageField {
            spacing: 2.0 * self.setup.spacing,
            positions: &self.body.first,
            damage: &damage,
            damage_time: &damage_time,
            time_step: self.body.clock.step,
            top_speed: self.problem.material.shear_speed(),
            scale: Vec3::repeat(1.0),
            normals: None,
            pieces: Some(&pieces),
            scored: &[],
        };
        let settings = CutSettings {
            min_volume_ratio: self.problem.settings.min_volume_ratio,
            max_fragments: self.problem.settings.max_fragments,
            seed: self.problem.seed,
            detail: self.problem.settings.brittle.detail,
        };
        cut::extract_stretched(&self.problem.solid, &field, &settings, &Vec3::repeat(1.0))
            .map_err(|error| Failure::Cut(error.to_string()))
    }

    /// How some points move together.
    fn motion(&self, all: &[usize]) -> FragmentMotion {
        let domain = &self.body.domain;
        let mass: f64 = all.iter().map(|&p| domain.mass(p)).sum();
        if mass <= 0.0 {
            return (Vec3::zeros(), Vec3::zeros());
        }
        let mean = |of: &[Vec3]| all.iter().map(|&p| of[p] * domain.mass(p)).sum::<Vec3>() / mass;
        let (centre, velocity) = (mean(&domain.places), mean(&domain.velocities));
        let (mut inertia, mut angular) = (Mat3::zeros(), Vec3::zeros());
        for &p in all {
            let (arm, m) = (domain.places[p] - centre, domain.mass(p));
            inertia += (Mat3::identity() * arm.norm_squared() - arm * arm.transpose()) * m;
            angular += arm.cross(&domain.velocities[p]) * m;
        }
        let inverse = inertia.try_inverse().filter(|_| all.len() >= FEW);
        (velocity, inverse.map_or(Vec3::zeros(), |inverse| inverse * angular))
    }

    /// Moves a part's vertices with its own points, as far as they have moved beside its motion:
    /// whether they have.
    fn bend(&self, part: &mut CutPart, all: &[usize]) -> Result<bool, Failure> {
        let shape = CarriedShape::of(&self.body, all, self.setup.spacing);
        let Some(shape) = shape.filter(|it| it.moved > LEAST_MOVE * self.setup.spacing) else {
            return Ok(false);
        };
        part.solid = shape.bent(&part.solid)?.solid;
        part.volume = part.solid.mesh.signed_volume();
        part.hulls = convex_parts(&part.solid, HullSettings::default());
        // They are where they were.
        part.cracks.clear();
        Ok(true)
    }

    /// The loose points and how they move.
    fn motes(&self, parts: &BondedParts) -> Motes {
        let (domain, first) = (&self.body.domain, &self.body.first);
        let loose = (0..first.len()).filter(|&p| parts.loose[p]);
        let mote = |p: usize| Mote { place: first[p], velocity: domain.velocities[p] };
        Motes { all: loose.map(mote).collect(), reach: 2.0 * self.setup.spacing }
    }
}

/// The points of a part of the cut: those that bonds hold together, if there are any.
fn members(of: &[u32], parts: &BondedParts, part: usize) -> Vec<usize> {
    let all: Vec<usize> = (0..of.len()).filter(|&p| of[p] as usize == part).collect();
    let mut votes = vec![0_usize; parts.count as usize];
    all.iter().filter_map(|&p| parts.of[p]).for_each(|k| votes[k as usize] += 1);
    let most = (0..parts.count).max_by_key(|&k| (votes[k as usize], std::cmp::Reverse(k)));
    match most.filter(|&k| votes[k as usize] > 0) {
        Some(k) => all.into_iter().filter(|&p| parts.of[p] == Some(k)).collect(),
        None => all,
    }
}

/// Whether most points of a part of the cut are loose.
fn is_heap(of: &[u32], parts: &BondedParts, part: usize) -> bool {
    let all = || (0..of.len()).filter(|&p| of[p] as usize == part);
    2 * all().filter(|&p| parts.loose[p]).count() > all().count()
}
