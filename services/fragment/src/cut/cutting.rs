//! One cut, in steps: regions, pieces, second thoughts, parts.

mod amend;

use super::{
    Body, CutError, CutSettings, FACET, OUTER, Part, Partition, VOLUME_TOLERANCE, boxed, unrelieved,
};
use crate::crack::Nodes;
use crate::grid_bias::GridBias;
use crate::region::terms::ReliefTerms;
use crate::region::{Mosaic, Side, agglomerate, triangle_area};
use amend::Homes;
use cullet_geometry::boolean::Exact;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::inside::{Inside, closest_on_triangle};
use cullet_geometry::math::scramble;
use cullet_geometry::surface::{barycentric, interpolate};
use cullet_geometry::voronoi::WALL;
use cullet_geometry::{Solid, Surface, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Pieces are looked over at most this often. A second round is rare; after the last, pieces that
/// are still to join a neighbour do so solid to solid.
const ROUNDS: u32 = 4;
/// Regions cut in one step: large enough to feed every core, small enough to cancel between steps.
const BATCH: usize = 64;
/// Times and speeds of a front are fitted over this many spacings.
const FRONT: f64 = 1.5;
/// A cell is this many spacings wide, where a look is given in spacings.
const CELL: f64 = 6.0;
/// Edges outside the body may be this long \[spacings\] before it is asked whether they matter.
const COARSE: f64 = 3.0;
/// Most facets, and triangles of a body, that can be named.
const MOST: usize = 1 << 30;

/// The lattice that a cut was found on, and how its fronts are measured.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    pub(super) nodes: Arc<Nodes>,
    /// As in [`super::DamageField`].
    pub(super) scale: Vec3,
    pub(super) top_speed: f64,
}

/// When the front passed \[s\], and how fast \[m/s\].
type Mark = [f32; 2];

impl Ground {
    /// When and how fast the front passed a place; `time` where the lattice does not tell.
    pub(super) fn mark(&self, place: Vec3, time: f64) -> Mark {
        let Some(front) = self.nodes.front(place, FRONT) else {
            return [time as f32, 0.0];
        };
        let slope = front.slope.component_div(&self.scale).norm();
        let speed = if slope * self.top_speed > 1.0 { 1.0 / slope } else { self.top_speed };
        [front.time.max(0.0) as f32, speed as f32]
    }
}

/// The mark of each corner of a mosaic that lies on a face between cells: where there is no ground,
/// or it does not tell, the mean time of the facets there. Both sides of a crack read them.
fn marks(mosaic: &Mosaic, ground: Option<&Ground>) -> Vec<Mark> {
    let mut sums = vec![(0.0, 0u32); mosaic.places.len()];
    for facet in mosaic.facets.iter().filter(|facet| facet.cells.1 < WALL) {
        for &corner in mosaic.of(facet).as_flattened() {
            sums[corner as usize].0 += facet.time;
            sums[corner as usize].1 += 1;
        }
    }
    let mark = |(&place, (sum, count)): (&Vec3, (f64, u32))| {
        let time = sum / f64::from(count.max(1));
        match ground {
            Some(ground) if count > 0 => ground.mark(place, time),
            _ => [time as f32, 0.0],
        }
    };
    mosaic.places.par_iter().zip(sums).map(mark).collect()
}

/// A piece of the body: a connected part of one region's share.
#[derive(Debug)]
struct Piece {
    label: u32,
    /// Labels of pieces that joined it.
    also: Vec<u32>,
    /// With faces named by facet.
    exact: Exact,
    /// With the true damage times.
    solid: Solid,
    volume: f64,
    /// The facets it ends at, and the area \[m²\] of each that is inside the body.
    contacts: Vec<(u32, f64)>,
    /// Area of those \[m²\], and of those with damage near by.
    crack: f64,
    damaged: f64,
    /// Whether all its faces are new.
    buried: bool,
}

/// A cut under way. [`Cutting::step`] until it is done, or [`Cutting::run`].
#[derive(Debug)]
pub struct Cutting {
    body: Body,
    mosaic: Mosaic,
    /// The label of each cell.
    labels: Vec<u32>,
    floor: f64,
    max: usize,
    ground: Option<Ground>,
    /// Of each corner of the mosaic.
    marks: Vec<Mark>,
    pieces: Vec<Piece>,
    /// Facets around each label of the current round, and the labels still to cut.
    sides: Vec<Vec<Side>>,
    todo: Vec<u32>,
    cut: usize,
    round: u32,
    pub(super) warnings: Vec<String>,
    /// Labels of the cells that each part of the result comes from.
    pub(super) part_labels: Vec<Vec<u32>>,
}

impl Cutting {
    /// Makes the diagram. `attempt` > 0 shakes the sites: for a second try after an accident.
    ///
    /// # Errors
    /// As [`super::by_sites`].
    pub fn begin(
        solid: &Solid,
        sites: &[Vec3],
        labels: &[u32],
        times: &[f64],
        settings: &CutSettings,
        attempt: u64,
    ) -> Result<Self, CutError> {
        let body = Body::new(solid, settings)?;
        let cells = boxed(&body, sites, labels, times, settings.seed, attempt)?;
        let mut mosaic = Mosaic::of_cells(&cells, times)?;
        if attempt == 0 && !settings.detail.is_none() {
            let spacing = libm::cbrt(body.volume / labels.len() as f64) / CELL;
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
        cutting.warnings.extend(unrelieved(settings, attempt));
        Ok(cutting)
    }

    /// `labels`: of each cell, all of 0, 1, 2, … in use. Parts are at least `floor` \[m³\], and at
    /// most `most`.
    pub(super) fn assemble(
        body: Body,
        mosaic: Mosaic,
        labels: Vec<u32>,
        (floor, max_fragments): (f64, u32),
        ground: Option<Ground>,
    ) -> Result<Self, CutError> {
        let most = mosaic.facets.len().max(body.solid.mesh.triangles.len());
        if most >= MOST {
            let (value, limit) = (most as f64, MOST as f64);
            return Err(CutError::TooLarge { what: "facets", value, limit });
        }
        let count = labels.iter().max().map_or(0, |&most| most as usize + 1);
        let sides = mosaic.sides(&labels, count);
        Ok(Self {
            marks: marks(&mosaic, ground.as_ref()),
            body,
            mosaic,
            labels,
            floor,
            max: max_fragments.max(1) as usize,
            ground,
            pieces: Vec::new(),
            sides,
            todo: (0..count as u32).collect(),
            cut: 0,
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
        self.cut as f64 / self.todo.len().max(1) as f64
    }

    /// Does a bounded piece of work; the result once there is nothing left to do.
    ///
    /// # Errors
    /// As [`Cutting::run`].
    pub fn step(&mut self) -> Result<Option<Partition>, CutError> {
        if self.sides.len() == 1 {
            self.part_labels = vec![vec![0]];
            let mut whole = self.body.clone().untouched(0);
            whole.warnings.append(&mut self.warnings);
            return Ok(Some(whole));
        }
        if self.cut < self.todo.len() {
            let batch = &self.todo[self.cut..(self.cut + BATCH).min(self.todo.len())];
            let cut: Vec<Vec<Piece>> = batch
                .par_iter()
                .map(|&label| self.pieces_of(label))
                .collect::<Result<_, CutError>>()?;
            self.cut += batch.len();
            self.pieces.extend(cut.into_iter().flatten());
            return Ok(None);
        }
        self.pieces.sort_by_key(|piece| piece.label);
        let groups = self.groups();
        self.round += 1;
        if self.round < ROUNDS && self.relabel(&groups) {
            return Ok(None);
        }
        self.join(&groups);
        self.finish().map(Some)
    }

    fn pieces_of(&self, label: u32) -> Result<Vec<Piece>, CutError> {
        let sides = &self.sides[label as usize];
        if sides.is_empty() {
            return Ok(Vec::new());
        }
        let (mesh, names) = self.mosaic.region(sides);
        let tags: Vec<u32> = names.iter().map(|name| FACET + name).collect();
        let share = self.body.exact.intersect(&Exact::tagged(&mesh, &tags)?)?;
        let parts = share.components()?;
        parts.into_iter().map(|part| self.piece(label, part)).collect()
    }

    /// Reads which facets a piece ends at, and gives its crack faces their times.
    fn piece(&self, label: u32, exact: Exact) -> Result<Piece, CutError> {
        let (mesh, tags) = exact.to_tagged()?;
        let mut solid = Solid { surface: Vec::with_capacity(tags.len()), mesh };
        let mut contacts: BTreeMap<u32, f64> = BTreeMap::new();
        let (mut crack, mut damaged) = (0.0, 0.0);
        for (t, &tag) in tags.iter().enumerate() {
            let corners = solid.mesh.corners(t);
            let Some(name) = facet_of(tag) else {
                solid.surface.push(self.body.surface_of(tag, corners));
                continue;
            };
            let area = triangle_area(&solid.mesh.vertices, solid.mesh.triangles[t]);
            *contacts.entry(name).or_insert(0.0) += area;
            crack += area;
            let middle = corners.iter().sum::<Vec3>() / 3.0;
            if self.ground.as_ref().is_none_or(|ground| ground.nodes.holds(middle)) {
                damaged += area;
            }
            let [damage_time, front_speed] = self.marks_in(name, corners);
            solid.surface.push(Surface::Crack { damage_time, front_speed, parent: 0 });
        }
        let volume = solid.mesh.signed_volume();
        let contacts = contacts.into_iter().collect();
        let buried = tags.iter().all(|&tag| facet_of(tag).is_some());
        let also = Vec::new();
        Ok(Piece { label, also, exact, solid, volume, contacts, crack, damaged, buried })
    }

    /// Times and speeds at the corners of a triangle that lies in a facet.
    fn marks_in(&self, facet: u32, corners: [Vec3; 3]) -> [[f32; 3]; 2] {
        let Mosaic { facets, places, .. } = &self.mosaic;
        let own = self.mosaic.of(&facets[facet as usize]);
        let at = |p: Vec3| -> Mark {
            if let Some(&v) = own.as_flattened().iter().find(|&&v| places[v as usize] == p) {
                return self.marks[v as usize];
            }
            let near = own.iter().map(|t| {
                let q = closest_on_triangle(p, t.map(|v| places[v as usize]));
                ((q - p).norm_squared(), t, q)
            });
            let Some((_, t, q)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                return [0.0; 2];
            };
            let weights = barycentric(q, t.map(|v| places[v as usize]));
            [0, 1].map(|k| interpolate(t.map(|v| self.marks[v as usize][k]), weights))
        };
        let marks = corners.map(at);
        [0, 1].map(|k| marks.map(|mark| mark[k]))
    }

    /// Which pieces belong together, each group named by its largest.
    fn groups(&self) -> Vec<u32> {
        let mut ends: Vec<(u32, u32, f64)> = Vec::new();
        for (p, piece) in self.pieces.iter().enumerate() {
            ends.extend(piece.contacts.iter().map(|&(facet, area)| (facet, p as u32, area)));
        }
        ends.sort_unstable_by_key(|&(facet, piece, _)| (facet, piece));
        let mut shared: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for group in ends.chunk_by(|a, b| a.0 == b.0) {
            for (k, &(_, p, mine)) in group.iter().enumerate() {
                for &(_, q, other) in &group[k + 1..] {
                    if self.pieces[p as usize].label != self.pieces[q as usize].label {
                        *shared.entry((p, q)).or_insert(0.0) += mine.min(other);
                    }
                }
            }
        }
        let volumes: Vec<f64> = self.pieces.iter().map(|piece| piece.volume).collect();
        // A crack of which less than half has damage behind it is an artefact (F27).
        let forced: Vec<bool> =
            self.pieces.iter().map(|piece| piece.damaged < 0.5 * piece.crack).collect();
        agglomerate(&volumes, &forced, &shared, self.floor, self.max)
    }

    fn finish(&mut self) -> Result<Partition, CutError> {
        let mut parts: Vec<(Part, Vec3, Vec<u32>)> = Vec::new();
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
            let part = Part { hulls: Vec::new(), solid, volume, cracks: Vec::new() };
            parts.push((part, centroid, piece.also));
        }
        parts.sort_by(|(p, a, _), (q, b, _)| {
            let by_place = || a.iter().zip(b.iter()).map(|(x, y)| x.total_cmp(y));
            q.volume.total_cmp(&p.volume).then_with(|| {
                by_place().find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
            })
        });
        self.part_labels = parts.iter_mut().map(|part| std::mem::take(&mut part.2)).collect();
        let mut parts: Vec<Part> = parts.into_iter().map(|part| part.0).collect();
        let (sum, whole) = (parts.iter().map(|part| part.volume).sum::<f64>(), self.body.volume);
        let closes = (sum - whole).abs() <= VOLUME_TOLERANCE * whole;
        if parts.is_empty() || !closes || parts.iter().any(|part| part.volume <= 0.0) {
            return Err(CutError::Volume { parts: parts.len(), sum, whole });
        }
        if parts.len() == 1 {
            self.part_labels = vec![(0..self.sides.len() as u32).collect()];
            return Ok(self.body.clone().untouched(0));
        }
        self.note(&parts, buried);
        parts.par_iter_mut().for_each(|part| part.hulls = hulls(&part.solid));
        Ok(Partition {
            parts,
            particle_part: Vec::new(),
            bias: GridBias::default(),
            // Both sides of a crack are new surface, and nothing else is.
            crack_area: (0.5 * (area - self.body.area)).max(0.0),
            warnings: std::mem::take(&mut self.warnings),
        })
    }

    /// Says what the settings asked for and the parts do not keep.
    fn note(&mut self, parts: &[Part], buried: usize) {
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
    pub(super) fn locate(&self, positions: &[Vec3], parts: &[Part]) -> Vec<u32> {
        let (Some(ground), true) = (&self.ground, parts.len() > 1) else {
            return vec![0; positions.len()];
        };
        let mut of_label: Vec<Vec<u32>> = vec![Vec::new(); self.sides.len()];
        for (p, labels) in self.part_labels.iter().enumerate() {
            for &label in labels {
                of_label[label as usize].push(p as u32);
            }
        }
        let all: Vec<u32> = (0..parts.len() as u32).collect();
        let choices = |&place: &Vec3| -> Vec<u32> {
            let near = ground.nodes.cells_at(place).map(|cell| self.labels[cell as usize]);
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

/// Convex stand-ins for a solid.
pub(super) fn hulls(solid: &Solid) -> Vec<Vec<Vec3>> {
    convex_parts(solid, HullSettings::default())
}

/// The facet that a tag names.
fn facet_of(tag: u32) -> Option<u32> {
    (tag < OUTER).then(|| tag.checked_sub(FACET)).flatten()
}
