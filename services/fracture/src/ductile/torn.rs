//! What becomes of a body that has torn: its parts are cut before the hit, as those of a brittle
//! one, and each is carried by its own points, so that the lips of a tear part.

use super::Ductile;
use crate::mpm::Domain;
use crate::mpm::crushed::LEAST_POINTS;
use crate::mpm::domain::PointMotion;
use crate::mpm::motion;
use crate::mpm::point_damage::{PointDamage, motes};
use crate::mpm::preconditions::stretch;
use cullet_fragment::carriers::Carriers;
use cullet_fragment::cut::{self, CutPart, CutSettings, OpenCrack, slit};
use cullet_fragment::finish::{Finish, FinishedParts, FragmentMotion};
use cullet_fragment::pieces::Pieces;
use cullet_fragment::reshaped::reshaped;
use cullet_fragment::straightened::Straightened;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::midsurface::vertex_normals;
use cullet_geometry::shapes::refine_solid;
use cullet_geometry::{Solid, Vec3};
use cullet_model::{Failure, FragmentOrigin, Fragmentation, Report};
use rayon::prelude::*;

/// Longest edge of the new surface in cells \[1\].
pub(super) const FINE: f64 = 0.75;

/// Width of the slits that tears which end inside a part are cut as, in cells: what opens is what
/// its sides do.
const SLIT: f64 = 0.02;

/// Change of volume of a part that its points make beyond which they have folded it \[1\].
const FOLDED: f64 = 0.3;

/// Where the points of a body are in its frame, and what they carry.
pub(super) struct TornShape<'a> {
    solve: &'a Ductile,
    straight: &'a Straightened,
    /// By slot.
    motions: &'a [PointMotion],
    carriers: Carriers,
}

/// Parts of a body, each in its own shape.
pub(super) struct TornParts {
    parts: Vec<CutPart>,
    /// Of each point by its number.
    part_of: Vec<u32>,
    /// Of each: whether it was shredded.
    crumbled: Vec<bool>,
    crack_area: f64,
    pub(super) warnings: Vec<String>,
}

impl TornParts {
    /// Whether there is more than one.
    pub(super) fn are_several(&self) -> bool {
        self.parts.len() > 1
    }

    /// The shape of the first.
    pub(super) fn only(self) -> Option<Solid> {
        self.parts.into_iter().next().map(|part| part.solid)
    }
}

impl Ductile {
    /// Leaves the largest piece where it was.
    pub(super) fn largest_stays(&self, motions: &[PointMotion]) -> Straightened {
        let pieces = self.domain.pieces();
        let count = pieces.iter().flatten().max().map_or(0, |&last| last as usize + 1);
        let mut sizes = vec![0; count];
        pieces.iter().flatten().for_each(|&piece| sizes[piece as usize] += 1);
        let largest = (0..count).rev().max_by_key(|&piece| sizes[piece]).map(|it| it as u32);
        let particles = &self.domain.particles;
        let own = (0..particles.len()).filter(|&p| pieces[particles.id[p] as usize] == largest);
        let own: Vec<usize> = own.collect();
        let masses: Vec<f64> = own.iter().map(|&p| particles.mass(p)).collect();
        let first: Vec<Vec3> = own.iter().map(|&p| particles.reference[p]).collect();
        let now = |&p: &usize| particles.reference[p] + motions[p].displacement;
        Straightened::of(&masses, &first, &own.iter().map(now).collect::<Vec<_>>())
    }
}

impl<'a> TornShape<'a> {
    pub(super) fn new(
        solve: &'a Ductile,
        straight: &'a Straightened,
        motions: &'a [PointMotion],
    ) -> Self {
        let particles = &solve.domain.particles;
        let place = |id: u32| particles.reference[solve.domain.slot(id)];
        let places = (0..particles.len() as u32).map(place).collect();
        let carriers = Carriers::new(places, solve.domain.grid.spacing.max());
        Self { solve, straight, motions, carriers }
    }

    /// Where a place before the hit is now, as the point of that number takes it along \[m\].
    fn taken(&self, id: usize, place: &Vec3) -> Vec3 {
        let slot = self.solve.domain.slot(id as u32);
        let (motion, from) = (&self.motions[slot], self.solve.domain.particles.reference[slot]);
        // In a tear the nearest point that holds is far, and its strain says little there.
        let (away, cell) = (place - from, self.solve.domain.grid.spacing.max());
        let near = (cell / away.norm()).min(1.0);
        place + motion.displacement + motion.displacement_gradient * away * near
    }

    /// Where a place of the surface is now, that has the unit normal `out` out of the body, and
    /// that points which `own` says may carry: those that hold together with the nearest one on its
    /// side of a tear.
    fn place(&self, place: &Vec3, out: &Vec3, own: &impl Fn(usize) -> bool) -> Option<Vec3> {
        let from = |id: usize| {
            let slot = self.solve.domain.slot(id as u32);
            self.solve.domain.particles.reference[slot] - place
        };
        let behind = |id: usize| own(id) && from(id).dot(out) <= 0.0;
        let nearest = self.carriers.nearest(place, behind);
        let nearest = nearest.or_else(|| self.carriers.nearest(place, own))?;
        let joined = self.solve.domain.joined(nearest as u32).map(|id| id as usize);
        let near = std::iter::once(nearest).chain(joined.filter(|&id| own(id)));
        let shares = self.carriers.shares_of(place, near);
        let sum = shares.iter().map(|&(id, share)| self.taken(id, place) * share).sum();
        Some(self.straight.place(&sum))
    }

    /// A solid that was cut out before the hit, where its own points are now, with a volume \[m³\];
    /// none where they fold it, or are too far.
    fn moved(
        &self,
        solid: &Solid,
        volume: f64,
        own: &(impl Fn(usize) -> bool + Sync),
    ) -> Result<Option<Solid>, Failure> {
        let spacing = self.solve.domain.grid.spacing.max();
        let solid =
            refine_solid(solid, FINE * spacing).map_err(|error| Failure::Cut(error.to_string()))?;
        let normals = vertex_normals(&solid.mesh);
        let pairs = solid.mesh.vertices.par_iter().zip(&normals);
        let moved: Option<Vec<Vec3>> = pairs.map(|(x, out)| self.place(x, out, own)).collect();
        let Some(moved) = moved else { return Ok(None) };
        let found = reshaped(solid, moved, volume).filter(|it| it.swollen.abs() <= FOLDED);
        Ok(found.map(|it| it.solid))
    }

    /// A solid in the shape that it had, where its own points have taken it.
    fn as_it_was(&self, solid: &Solid, own: &impl Fn(usize) -> bool) -> Option<Solid> {
        let particles = &self.solve.domain.particles;
        let slots = (0..particles.len()).filter(|&id| own(id));
        let slots: Vec<usize> = slots.map(|id| self.solve.domain.slot(id as u32)).collect();
        if slots.is_empty() {
            return None;
        }
        let masses: Vec<f64> = slots.iter().map(|&p| particles.mass(p)).collect();
        let first: Vec<Vec3> = slots.iter().map(|&p| particles.reference[p]).collect();
        let now = |&p: &usize| particles.reference[p] + self.motions[p].displacement;
        let now: Vec<Vec3> = slots.iter().map(|p| self.straight.place(&now(p))).collect();
        let way = Straightened::of(&masses, &now, &first);
        let mut solid = solid.clone();
        solid.mesh.vertices.iter_mut().for_each(|x| *x = way.place(x));
        Some(solid)
    }

    /// Cuts the body along its tears, and moves what there is then.
    ///
    /// # Errors
    /// If it cannot be cut, or a part has no shape.
    pub(super) fn parts(&self) -> Result<TornParts, Failure> {
        let Ductile { problem, domain, .. } = self.solve;
        let damage = PointDamage::of(domain);
        let tolerance = problem.settings.tolerance();
        let (of, found, shreds) = shredded(domain);
        let pieces = Pieces { of, found, tolerance, ..Pieces::default() };
        let field = damage.field(domain, problem.material.shear_speed(), &pieces);
        let settings = CutSettings {
            min_volume_ratio: problem.settings.min_volume_ratio,
            max_fragments: problem.settings.max_fragments,
            seed: problem.seed,
            detail: problem.settings.brittle.detail,
        };
        let stretch = stretch(&domain.grid.spacing);
        let mut partition = cut::extract_stretched(&problem.solid, &field, &settings, &stretch)
            .map_err(|error| Failure::Cut(error.to_string()))?;
        let (part_of, mut folded) = (partition.particle_part, 0);
        let crumbled = crumbled(partition.parts.len(), &part_of, &pieces, shreds);
        for (k, part) in partition.parts.iter_mut().enumerate() {
            let volume = part.solid.mesh.signed_volume();
            let own = |id: usize| part_of[id] as usize == k;
            let before = part.solid.clone();
            let as_it_was = || self.as_it_was(&before, &own).unwrap_or_else(|| before.clone());
            let cracks = std::mem::take(&mut part.cracks);
            if crumbled[k] {
                part.solid = as_it_was();
                continue;
            }
            self.slit(part, &cracks, &mut partition.warnings);
            // What slits took is given back. Crumbs carry nothing.
            let bears = |id: usize| own(id) && pieces.of[id].is_some_and(|piece| piece < shreds);
            let moved = self.moved(&part.solid, volume, &bears)?;
            folded += u32::from(moved.is_none());
            part.solid = moved.unwrap_or_else(as_it_was);
            part.hulls = convex_parts(&part.solid, HullSettings::default());
        }
        if folded > 0 {
            partition.warnings.push(format!(
                "{folded} of {} parts were folded by their points: they are shown in the shape \
                 that they had",
                partition.parts.len()
            ));
        }
        let (parts, crack_area) = (partition.parts, partition.crack_area);
        Ok(TornParts { parts, part_of, crumbled, crack_area, warnings: partition.warnings })
    }

    /// Cuts the tears that end inside a part as slits, so that they can open.
    fn slit(&self, part: &mut CutPart, cracks: &[OpenCrack], warnings: &mut Vec<String>) {
        let spacing = self.solve.domain.grid.spacing.min();
        for crack in cracks {
            match slit::open(&part.solid, &crack.beyond, SLIT * spacing, spacing) {
                Ok(found) => part.solid = found.solid,
                Err(slit::SlitError::Nothing) => {}
                Err(why) => warnings.push(format!("a tear that ends inside stays closed: {why}")),
            }
        }
    }

    /// How far each part has flown beside the first since a striker touched the body last \[m\].
    fn flown(&self, motions: &[FragmentMotion]) -> Vec<Vec3> {
        let touched = self.solve.strikers.iter().filter_map(|it| it.touched).fold(0.0, f64::max);
        let time = self.solve.domain.time - touched;
        let first = motions.first().map_or_else(Vec3::zeros, |motion| motion.0);
        let far = |(velocity, _): &FragmentMotion| self.straight.motion(&(velocity - first)) * time;
        motions.iter().map(far).collect()
    }

    /// The parts as they move.
    pub(super) fn broken(&self, mut torn: TornParts, mut report: Report) -> Fragmentation {
        let Ductile { problem, domain, .. } = self.solve;
        report.crack_area = torn.crack_area;
        report.fracture_energy = self.solve.record.plastic + self.solve.record.torn;
        report.warnings.extend(torn.warnings);
        let motions = motion::of_parts(domain, &torn.part_of, torn.parts.len());
        let motions: Vec<FragmentMotion> = motions.iter().map(|m| (m.velocity, m.spin)).collect();
        // Parts go back to where they were then.
        let flown = self.flown(&motions);
        for (part, far) in torn.parts.iter_mut().zip(&flown) {
            part.solid.mesh.vertices.iter_mut().for_each(|x| *x -= far);
            part.hulls.iter_mut().flatten().for_each(|x| *x -= far);
        }
        let place = |p: usize| {
            let now = domain.particles.reference[p] + self.motions[p].displacement;
            let part = torn.part_of[domain.particles.id[p] as usize] as usize;
            self.straight.place(&now) - flown.get(part).copied().unwrap_or_default()
        };
        let (momentum, moment) = self.solve.given();
        let finish = Finish {
            problem,
            spacing: (domain.grid.spacing.min(), domain.grid.spacing.max()),
            motes: &motes(domain, place),
            pushes: &[],
        };
        let FinishedParts { fragments, debris, warnings } =
            finish.carrying(torn.parts, &motions, &torn.crumbled, [momentum, moment]);
        report.warnings.extend(warnings);
        let origins = vec![FragmentOrigin::Solved; fragments.len()];
        let reactions = self.solve.reactions();
        Fragmentation { fragments, origins, debris, reactions, report }
    }
}

/// The piece of each point, how many there are, and from which on they are shreds: what has torn or
/// is left of too few points, and has no neighbour in a piece. What lies beside one, and a tear
/// with pieces on both of its sides, is shared out between them.
fn shredded(domain: &Domain) -> (Vec<Option<u32>>, u32, u32) {
    let mut pieces = domain.pieces();
    let first = pieces.iter().flatten().max().map_or(0, |&last| last + 1);
    let mut sizes = vec![0; first as usize];
    pieces.iter().flatten().for_each(|&piece| sizes[piece as usize] += 1);
    for piece in &mut pieces {
        *piece = piece.filter(|&piece| sizes[piece as usize] >= LEAST_POINTS);
    }
    let lone = |id: u32| {
        let beside = |other: u32| pieces[other as usize].is_some();
        !beside(id) && !domain.neighbours(id).any(beside)
    };
    let lone: Vec<bool> = (0..pieces.len() as u32).map(lone).collect();
    let mut next = first;
    let mut seen = vec![false; pieces.len()];
    for start in 0..pieces.len() {
        if seen[start] || !lone[start] {
            continue;
        }
        let (mut zone, mut at) = (vec![start as u32], 0);
        seen[start] = true;
        while let Some(&id) = zone.get(at) {
            at += 1;
            for other in domain.neighbours(id) {
                if lone[other as usize] && !std::mem::replace(&mut seen[other as usize], true) {
                    zone.push(other);
                }
            }
        }
        if zone.len() >= LEAST_POINTS {
            zone.iter().for_each(|&id| pieces[id as usize] = Some(next));
            next += 1;
        }
    }
    (pieces, next, first)
}

/// Which parts were mostly shreds: pieces from `shreds` on.
fn crumbled(parts: usize, part_of: &[u32], pieces: &Pieces, shreds: u32) -> Vec<bool> {
    let mut votes = vec![0_i64; parts];
    for (&part, piece) in part_of.iter().zip(&pieces.of) {
        if let (Some(vote), Some(piece)) = (votes.get_mut(part as usize), piece) {
            *vote += if *piece >= shreds { 1 } else { -1 };
        }
    }
    let mut found: Vec<bool> = votes.into_iter().map(|vote| vote > 0).collect();
    // Something is left.
    if found.iter().all(|&gone| gone) {
        found[..1].fill(false);
    }
    found
}
