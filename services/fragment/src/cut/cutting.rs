//! One cut, in steps: regions, pieces, second thoughts, parts.

use super::body::{CutBody, hulls};
use super::ground::Ground;
use super::homes::Homes;
use super::partition::{CutPart, CutSettings, Partition};
use super::piece::{CutPiece, groups};
use super::regions::Regions;
use super::sites::cells_of;
use super::workpiece::Workpiece;
use crate::error::{CutError, VOLUME_TOLERANCE};
use crate::grid_bias::GridBias;
use crate::region::Mosaic;
use crate::region::terms::ReliefTerms;
use cullet_geometry::inside::Inside;
use cullet_geometry::math::scramble;
use cullet_geometry::{Solid, Vec3};
use rayon::prelude::*;

/// Pieces are looked over at most this often. A second round is rare; after the last, pieces that
/// are still to join a neighbour do so solid to solid.
const ROUNDS: u32 = 4;
/// A cell is this many spacings wide, where a look is given in spacings.
const CELL: f64 = 6.0;
/// Edges outside the body may be this long \[spacings\] before it is asked whether they matter.
const COARSE: f64 = 3.0;

/// A cut under way. [`Cutting::step`] until it is done, or [`Cutting::run`].
#[derive(Debug)]
pub struct Cutting {
    workpiece: Workpiece,
    regions: Regions,
    /// What was cut in all rounds so far.
    pieces: Vec<CutPiece>,
    /// Parts are at least so large \[m³\].
    floor: f64,
    /// Most parts.
    max: usize,
    round: u32,
    warnings: Vec<String>,
    /// Labels of the cells that each part of the result comes from.
    pub(super) part_labels: Vec<Vec<u32>>,
}

impl Cutting {
    /// Makes the diagram. `cells` says into how many the body is divided, by whose size relief is
    /// measured. `attempt` > 0 shakes the sites: for a second try after an accident.
    ///
    /// # Errors
    /// As [`super::by_sites`].
    pub fn begin(
        solid: &Solid,
        sites: &[Vec3],
        labels: &[u32],
        times: &[f64],
        cells: usize,
        settings: &CutSettings,
        attempt: u64,
    ) -> Result<Self, CutError> {
        let body = CutBody::new(solid, settings)?;
        let diagram = cells_of(&body, sites, labels, times, settings.seed, attempt)?;
        let mut mosaic = Mosaic::of_cells(&diagram, times)?;
        if attempt == 0 && !settings.detail.is_none() {
            let spacing = libm::cbrt(body.volume / cells as f64) / CELL;
            let terms = ReliefTerms {
                detail: settings.detail,
                spacing,
                time_step: f64::INFINITY,
                seed: scramble(settings.seed),
            };
            let inside = Inside::new(&solid.mesh);
            let coarse = COARSE * spacing;
            mosaic.engrave(
                &terms,
                |_| None,
                |ends| {
                    let [a, b, _] = ends;
                    (b - a).norm() > coarse || ends.iter().any(|&p| inside.contains(p))
                },
            );
        }
        // Labels become 0, 1, 2, … in ascending order.
        let mut names = labels.to_vec();
        names.sort_unstable();
        names.dedup();
        let rank = |label: &u32| names.partition_point(|other| other < label) as u32;
        let labels = labels.iter().map(rank).collect();
        let floor = settings.min_volume_ratio * body.volume;
        let mut cutting =
            Self::assemble(body, mosaic, labels, (floor, settings.max_fragments), None)?;
        if attempt > 0 && !settings.detail.is_none() {
            let count = attempt + 1;
            let warning =
                format!("crack faces have no relief: only attempt {count} at the cut closed");
            cutting.warnings.push(warning);
        }
        Ok(cutting)
    }

    /// `labels`: of each cell, all of 0, 1, 2, … in use. Parts are at least `floor` \[m³\], and at
    /// most `max_fragments`.
    pub(super) fn assemble(
        body: CutBody,
        mosaic: Mosaic,
        labels: Vec<u32>,
        (floor, max_fragments): (f64, u32),
        ground: Option<Ground>,
    ) -> Result<Self, CutError> {
        let workpiece = Workpiece::new(body, mosaic, ground)?;
        Ok(Self {
            regions: Regions::new(&workpiece.mosaic, labels),
            workpiece,
            pieces: Vec::new(),
            floor,
            max: max_fragments.max(1) as usize,
            round: 0,
            warnings: Vec::new(),
            part_labels: Vec::new(),
        })
    }

    /// Does it all.
    ///
    /// # Errors
    /// The kernel's refusal, or [`CutError::Volume`].
    pub fn run(&mut self) -> Result<Partition, CutError> {
        loop {
            if let Some(partition) = self.step()? {
                return Ok(partition);
            }
        }
    }

    /// The share of the known work that is done, in `[0, 1]`.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.regions.share()
    }

    /// Does a bounded piece of work; the result once there is nothing left to do.
    ///
    /// # Errors
    /// As [`Cutting::run`].
    pub fn step(&mut self) -> Result<Option<Partition>, CutError> {
        if self.regions.sides.len() == 1 {
            self.part_labels = vec![vec![0]];
            let mut whole = self.workpiece.body.clone().untouched(0);
            whole.warnings.append(&mut self.warnings);
            return Ok(Some(whole));
        }
        let batch = self.regions.batch();
        if !batch.is_empty() {
            let pieces_of =
                |&label: &u32| self.workpiece.pieces_of(label, &self.regions.sides[label as usize]);
            let cut: Vec<Vec<CutPiece>> =
                batch.par_iter().map(pieces_of).collect::<Result<_, CutError>>()?;
            self.regions.advance(cut.len());
            self.pieces.extend(cut.into_iter().flatten());
            return Ok(None);
        }
        self.pieces.sort_by_key(|piece| piece.label);
        let groups = groups(&self.pieces, self.floor, self.max);
        self.round += 1;
        let mosaic = &self.workpiece.mosaic;
        if self.round < ROUNDS && self.regions.relabel(mosaic, &mut self.pieces, &groups) {
            return Ok(None);
        }
        self.join(&groups);
        self.finish().map(Some)
    }

    /// Joins pieces with siblings elsewhere (cells reach across gaps) to their hosts, solid to
    /// solid. What the kernel cannot join stays.
    fn join(&mut self, groups: &[u32]) {
        let mut gone = vec![false; self.pieces.len()];
        let mut left = 0;
        for (p, &host) in groups.iter().enumerate() {
            let host = host as usize;
            if host == p {
                continue;
            }
            match self.workpiece.union(&self.pieces[host], &self.pieces[p]) {
                Some(mut joined) => {
                    joined.also.extend(self.pieces[host].also.iter().copied());
                    joined.also.extend(self.pieces[p].also.iter().copied());
                    joined.also.push(self.pieces[p].label);
                    self.pieces[host] = joined;
                    gone[p] = true;
                }
                None => left += 1,
            }
        }
        if left > 0 {
            self.warnings.push(format!("{left} small parts could not be joined to a neighbour"));
        }
        let mut gone = gone.into_iter();
        self.pieces.retain(|_| !gone.next().unwrap_or(false));
    }

    fn finish(&mut self) -> Result<Partition, CutError> {
        let mut parts: Vec<(CutPart, Vec3, Vec<u32>)> = Vec::new();
        let mut area = 0.0;
        // F33: what has no face of the body's own touches other parts only.
        let buried = self.pieces.iter().filter(|piece| piece.buried).count();
        for mut piece in std::mem::take(&mut self.pieces) {
            piece.also.push(piece.label);
            piece.also.sort_unstable();
            piece.also.dedup();
            area += piece.solid.mesh.area();
            let centroid = piece.solid.mesh.mass_properties().centroid;
            let (solid, volume) = (piece.solid, piece.volume);
            let part = CutPart { hulls: Vec::new(), solid, volume, cracks: Vec::new() };
            parts.push((part, centroid, piece.also));
        }
        parts.sort_by(|(p, a, _), (q, b, _)| {
            let by_place = || a.iter().zip(b.iter()).map(|(x, y)| x.total_cmp(y));
            q.volume.total_cmp(&p.volume).then_with(|| {
                by_place().find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
            })
        });
        self.part_labels = parts.iter_mut().map(|part| std::mem::take(&mut part.2)).collect();
        let mut parts: Vec<CutPart> = parts.into_iter().map(|part| part.0).collect();
        let (sum, whole) =
            (parts.iter().map(|part| part.volume).sum::<f64>(), self.workpiece.body.volume);
        let closes = (sum - whole).abs() <= VOLUME_TOLERANCE * whole;
        if parts.is_empty() || !closes || parts.iter().any(|part| part.volume <= 0.0) {
            return Err(CutError::Volume { parts: parts.len(), sum, whole });
        }
        if parts.len() == 1 {
            self.part_labels = vec![(0..self.regions.sides.len() as u32).collect()];
            return Ok(self.workpiece.body.clone().untouched(0));
        }
        self.note(&parts, buried);
        parts.par_iter_mut().for_each(|part| part.hulls = hulls(&part.solid));
        Ok(Partition {
            parts,
            particle_part: Vec::new(),
            bias: GridBias::default(),
            // Both sides of a crack are new surface, and nothing else is.
            crack_area: (0.5 * (area - self.workpiece.body.area)).max(0.0),
            warnings: std::mem::take(&mut self.warnings),
        })
    }

    /// Says what the settings asked for and the parts do not keep.
    fn note(&mut self, parts: &[CutPart], buried: usize) {
        let small = parts.iter().filter(|part| part.volume < self.floor).count();
        if small > 0 {
            self.warnings.push(format!(
                "{small} separate parts are below the least volume of {:.3e} m³",
                self.floor
            ));
        }
        if buried > 0 {
            self.warnings.push(format!("{buried} of the parts are enclosed by others"));
        }
        if parts.len() > self.max {
            self.warnings.push(format!("{} parts, {} were wanted at most", parts.len(), self.max));
        }
    }

    /// The part that each particle lies in, for the parts of the last [`Cutting::finish`].
    pub(super) fn locate(&self, positions: &[Vec3], parts: &[CutPart]) -> Vec<u32> {
        let (Some(ground), true) = (&self.workpiece.ground, parts.len() > 1) else {
            return vec![0; positions.len()];
        };
        let mut of_label: Vec<Vec<u32>> = vec![Vec::new(); self.regions.sides.len()];
        for (p, labels) in self.part_labels.iter().enumerate() {
            for &label in labels {
                of_label[label as usize].push(p as u32);
            }
        }
        let all: Vec<u32> = (0..parts.len() as u32).collect();
        let choices = |&place: &Vec3| -> Vec<u32> {
            let near = ground.nodes.cells_at(place).map(|cell| self.regions.labels[cell as usize]);
            let mut parts: Vec<u32> =
                near.flat_map(|label| of_label[label as usize].iter().copied()).collect();
            parts.sort_unstable();
            parts.dedup();
            if parts.is_empty() { all.clone() } else { parts }
        };
        let choices: Vec<Vec<u32>> = positions.par_iter().map(choices).collect();
        let mut doubtful: Vec<u32> =
            choices.iter().filter(|c| c.len() > 1).flatten().copied().collect();
        doubtful.sort_unstable();
        doubtful.dedup();
        let homes = Homes::new(doubtful.iter().map(|&p| (p, &parts[p as usize].solid)));
        let home = |(&p, choice): (&Vec3, &Vec<u32>)| match choice.as_slice() {
            &[only] => only,
            several => homes.of(p, several),
        };
        positions.par_iter().zip(&choices).map(home).collect()
    }
}
