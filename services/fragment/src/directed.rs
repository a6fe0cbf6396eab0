//! Fragments as the scene asks for them: so many, one at each guide point, regions in one piece.
//!
//! This is art direction, not mechanics: it works on what any family of solvers found, decides
//! nothing about whether a body breaks, and marks what it touched as
//! [`cullet_model::FragmentOrigin::Directed`]. Too few fragments are divided by Voronoi cells,
//! dense near the hits; too many are joined, the smallest first, to the neighbour with which they
//! share the largest face. Parts move as the fragment they are cut from, and joined ones share
//! their momenta, so momentum and angular momentum are kept exactly and kinetic energy never
//! grows.

mod crack_areas;
mod guarded;
mod joined;
mod piece;
mod sites;

use crate::cut::CutSettings;
use crack_areas::crack_areas;
use cullet_geometry::Vec3;
use cullet_geometry::math::scramble;
use cullet_model::outcome::{ADDED_CRACK_AREA, CLOSED_CRACK_AREA, FOUND_FRAGMENTS, FOUND_LARGEST};
use cullet_model::{ArtDirection, Fragmentation, Problem};
use guarded::{HeldRegions, LabelledSites};
use joined::{United, neighbours, overlapping, unite};
use piece::DirectedPiece;
use rayon::prelude::*;
use sites::{HitDensity, allotted, holders, with_guides};

/// Rounds of dividing and joining: cells of a hollow body fall apart, and slivers join others.
const ROUNDS: u64 = 8;
/// As far from the number asked for as this share of it is near enough \[1\].
pub const PIECES_TOLERANCE: f64 = 0.2;
/// A largest fragment above this share of the volume was only chipped \[1\].
const CHIPPED: f64 = 0.98;
/// Stream of the seed's numbers.
const STREAM: u64 = 0xd12e;

/// Gives a broken body the fragments that are asked for; `None` if it was cancelled. A body of
/// fewer than two fragments did not break, and stays as it is. One of two or more never ends with
/// fewer than two: it would not be broken any more.
#[must_use]
pub fn direct(
    mut fracture: Fragmentation,
    problem: &Problem,
    direction: &ArtDirection,
    cancelled: &dyn Fn() -> bool,
) -> Option<Fragmentation> {
    let found = fracture.fragments.len();
    if direction.is_none() {
        return Some(fracture);
    }
    if found < 2 {
        if !fracture.debris.is_empty() {
            let warning = "it only crumbled: without a crack through it there are no pieces to ask";
            fracture.report.warnings.push(format!("{warning} for"));
        }
        return Some(fracture);
    }
    let volumes = fracture.fragments.iter().map(|part| part.solid.mesh.signed_volume());
    let whole: f64 = volumes.clone().sum();
    let largest = volumes.fold(0.0, f64::max) / whole;
    if largest > CHIPPED {
        let share = 100.0 * largest;
        let warning = format!("the hit only chipped it: {share:.1} % were left in one piece");
        fracture.report.warnings.push(warning);
    }
    let origins = fracture.origins.iter().copied().chain(std::iter::repeat(Default::default()));
    let pieces = fracture.fragments.iter().cloned().zip(origins).map(DirectedPiece::new).collect();
    let mut body = DirectedBody::new(problem, direction, pieces);
    if !body.shape(found, cancelled) {
        return None;
    }
    let (mut added, mut closed) = (0.0, 0.0);
    if body.pieces.len() < 2 {
        let warning = "what stays whole leaves no room for a crack: the pieces are as found";
        fracture.report.warnings.push(warning.to_owned());
    } else {
        body.note();
        body.pieces.sort_by(DirectedPiece::order);
        (added, closed) = crack_areas(&fracture.fragments, &body.pieces);
        let DirectedBody { pieces, warnings, .. } = body;
        (fracture.fragments, fracture.origins) =
            pieces.into_iter().map(|piece| (piece.fragment, piece.origin)).unzip();
        fracture.report.warnings.extend(warnings);
    }
    fracture.report = fracture
        .report
        .with(FOUND_FRAGMENTS, "1", found as f64)
        .with(FOUND_LARGEST, "1", largest)
        .with(ADDED_CRACK_AREA, "m²", added)
        .with(CLOSED_CRACK_AREA, "m²", closed);
    Some(fracture)
}

/// A broken body under direction.
struct DirectedBody<'a> {
    problem: &'a Problem,
    direction: &'a ArtDirection,
    density: HitDensity,
    /// \[m³\]
    volume: f64,
    pieces: Vec<DirectedPiece>,
    warnings: Vec<String>,
}

impl<'a> DirectedBody<'a> {
    fn new(problem: &'a Problem, direction: &'a ArtDirection, pieces: Vec<DirectedPiece>) -> Self {
        let volume = pieces.iter().map(|piece| piece.properties.volume).sum();
        let corners = pieces.iter().flat_map(|piece| &piece.fragment.solid.mesh.vertices);
        let (low, high) = corners
            .fold((Vec3::repeat(f64::MAX), Vec3::repeat(f64::MIN)), |(low, high), x| {
                (low.inf(x), high.sup(x))
            });
        let density = HitDensity::new(&problem.impacts, (high - low).norm());
        Self { problem, direction, density, volume, pieces, warnings: Vec::new() }
    }

    /// Divides and joins; whether it was not cancelled. `found`: fragments before.
    fn shape(&mut self, found: usize, cancelled: &dyn Fn() -> bool) -> bool {
        self.keep_whole();
        if cancelled() {
            return false;
        }
        self.part_guides();
        for round in 0..ROUNDS {
            if cancelled() {
                return false;
            }
            // What stays whole has joined all that was found: cracks go round it instead.
            let all = (self.pieces.len() < 2).then_some(found);
            if all.is_some() {
                self.pieces.iter_mut().for_each(|piece| piece.is_stuck = false);
            }
            let wanted = self.direction.pieces.map(|pieces| pieces as usize).or(all);
            let Some(wanted) = wanted.filter(|wanted| *wanted != self.pieces.len()) else {
                break;
            };
            self.divide(wanted, round);
            self.keep_whole();
            self.join(wanted);
        }
        true
    }

    /// Joins the pieces that reach into a region that stays whole.
    fn keep_whole(&mut self) {
        for region in &self.direction.whole {
            let within = overlapping(&self.pieces, region);
            if within.len() > 1 {
                self.unite(&[within], false);
            }
        }
    }

    /// Joins the pieces of each group as far as they touch. `marks`: those that do not are not
    /// tried again before something was joined.
    fn unite(&mut self, groups: &[Vec<usize>], marks: bool) {
        let united: Vec<United> =
            groups.par_iter().map(|members| unite(&self.pieces, members, self.volume)).collect();
        let mut gone = vec![false; self.pieces.len()];
        let (mut fresh, mut alone) = (Vec::new(), Vec::new());
        for United { piece, members, left } in united {
            alone.extend(left);
            let Some(piece) = piece else { continue };
            members.iter().for_each(|&k| gone[k] = true);
            fresh.push(piece);
        }
        if marks {
            let changed = !fresh.is_empty();
            self.pieces.iter_mut().for_each(|piece| piece.is_alone &= !changed);
            alone.iter().for_each(|&k| self.pieces[k].is_alone = true);
        }
        let mut gone = gone.into_iter();
        self.pieces.retain(|_| !gone.next().unwrap_or(false));
        self.pieces.extend(fresh);
    }

    /// Divides the pieces that hold several guide points, at these.
    fn part_guides(&mut self) {
        let guides = &self.direction.guides;
        let held = holders(&self.pieces, guides);
        let key = scramble(self.problem.seed ^ STREAM);
        let of = |(k, piece): (usize, &DirectedPiece)| -> LabelledSites {
            let own: Vec<Vec3> = guides_of(guides, &held, k);
            if own.len() < 2 {
                return LabelledSites::default();
            }
            let regions = HeldRegions::new(&piece.fragment.solid.mesh, &self.direction.whole);
            let free: Vec<Vec3> = own.into_iter().filter(|guide| !regions.has(guide)).collect();
            regions.around(&free, scramble(key).wrapping_add(k as u64))
        };
        let sites: Vec<LabelledSites> = self.pieces.par_iter().enumerate().map(of).collect();
        self.cut(&sites, 0);
        // Random sites beside them may still do.
        self.pieces.iter_mut().for_each(|piece| piece.is_stuck = false);
        self.keep_whole();
    }

    /// Divides the largest pieces, by how densely cells are to lie in them, until there are enough.
    fn divide(&mut self, wanted: usize, round: u64) {
        if wanted <= self.pieces.len() {
            return;
        }
        let seed = scramble(self.problem.seed ^ STREAM).wrapping_add(round);
        let weigh = |(k, piece): (usize, &DirectedPiece)| {
            if piece.is_stuck {
                0.0
            } else {
                self.density.weight(piece, scramble(seed).wrapping_add(k as u64))
            }
        };
        let weights: Vec<f64> = self.pieces.par_iter().enumerate().map(weigh).collect();
        let cells = allotted(&weights, wanted);
        let held = holders(&self.pieces, &self.direction.guides);
        let choose = |(k, &count): (usize, &usize)| {
            if count < 2 {
                return LabelledSites::default();
            }
            let guides = guides_of(&self.direction.guides, &held, k);
            let key = scramble(seed).wrapping_add(k as u64);
            let whole = &self.direction.whole[..];
            with_guides(&self.pieces[k], (&guides, whole), count, &self.density, key)
        };
        let sites: Vec<LabelledSites> = cells.par_iter().enumerate().map(choose).collect();
        self.cut(&sites, round + 1);
    }

    /// Cuts each piece along the cells of its sites; one that cannot be cut is left, and not tried
    /// again.
    fn cut(&mut self, sites: &[LabelledSites], round: u64) {
        let settings = &self.problem.settings;
        let floor = settings.min_volume_ratio * self.volume;
        let parts = |(k, piece): (usize, &DirectedPiece)| {
            let own = &sites[k];
            let count = own.count();
            (count > 1).then(|| {
                let mean = 1.0 / count as f64;
                let settings = CutSettings {
                    min_volume_ratio: (floor / piece.properties.volume).min(0.5 * mean),
                    max_fragments: count as u32,
                    seed: scramble(self.problem.seed ^ round).wrapping_add(k as u64),
                    detail: settings.brittle.detail,
                };
                piece.cut(own, &settings)
            })
        };
        let cut: Vec<_> = self.pieces.par_iter().enumerate().map(parts).collect();
        let mut pieces = Vec::with_capacity(self.pieces.len());
        for (mut piece, cut) in std::mem::take(&mut self.pieces).into_iter().zip(cut) {
            match cut {
                None => pieces.push(piece),
                Some(Some((parts, warnings))) => {
                    pieces.extend(parts);
                    self.warnings.extend(warnings);
                }
                Some(None) => {
                    piece.is_stuck = true;
                    pieces.push(piece);
                }
            }
        }
        self.pieces = pieces;
        self.warnings.sort();
        self.warnings.dedup();
    }

    /// Joins the smallest pieces until there are no more than are wanted; those that hold guide
    /// points stay apart.
    fn join(&mut self, wanted: usize) {
        if wanted >= self.pieces.len() {
            return;
        }
        let held = holders(&self.pieces, &self.direction.guides);
        let apart = (0..self.pieces.len()).map(|k| held.contains(&k)).collect();
        self.unite(&neighbours(&self.pieces, apart, wanted), true);
    }

    /// Says what was asked for and did not come.
    fn note(&mut self) {
        let torn = |region| overlapping(&self.pieces, region).len() > 1;
        let torn = self.direction.whole.iter().filter(|region| torn(region)).count();
        if torn > 0 {
            self.warnings.push(format!("{torn} regions that stay whole could not be joined"));
        }
        let mut held = holders(&self.pieces, &self.direction.guides);
        held.sort_unstable();
        held.dedup();
        let (own, all) = (held.len(), self.direction.guides.len());
        if own < all {
            let warning = format!("{own} pieces hold the {all} guide points: each was to have one");
            self.warnings.push(warning);
        }
        let Some(wanted) = self.direction.pieces.map(|pieces| pieces as usize) else { return };
        let (have, most) = (self.pieces.len(), PIECES_TOLERANCE * wanted as f64);
        if (have as f64 - wanted as f64).abs() > most {
            self.warnings.push(format!("{have} pieces, {wanted} were asked for"));
        }
    }
}

/// The guide points that a piece holds.
fn guides_of(guides: &[Vec3], holders: &[usize], piece: usize) -> Vec<Vec3> {
    let own = guides.iter().zip(holders).filter(|(_, holder)| **holder == piece);
    own.map(|(guide, _)| *guide).collect()
}

#[cfg(test)]
mod tests;
