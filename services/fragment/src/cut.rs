//! Cuts a body along the faces between Voronoi cells of different labels, exactly.
//!
//! [`extract`] makes cells and labels from damage, [`by_sites`] takes them from the caller,
//! [`Cutting`] does the work in steps. Regions (unions of cells of one label) are intersected with
//! the body; a region may leave several pieces. Pieces that are too small, too many, or cut off by
//! a crack without damage behind it go to the neighbour with which they share the largest area:
//! their cells change label and the regions concerned are cut again. Every part is closed, and the
//! volumes of the parts sum to the body's within [`VOLUME_TOLERANCE`], or there is an error.

mod again;
mod cutting;
mod partial;
pub mod slit;
mod stretched;
#[cfg(test)]
mod tests;

use again::Way;
pub use again::extract_stretched;
pub use cutting::Cutting;
use cutting::Ground;

use crate::crack::Nodes;
use crate::grid_bias::GridBias;
use crate::pieces::Pieces;
use crate::region::agglomerate;
use crate::region::terms::ReliefTerms;
use cullet_geometry::boolean::{BooleanError, Exact, MAX_TAG};
use cullet_geometry::math::{scramble, unit};
use cullet_geometry::voronoi::{Cells, VoronoiError};
use cullet_geometry::{Sheet, Solid, Surface, Vec3};
use cullet_model::Detail;
use std::sync::Arc;

/// The parts' volumes sum to the body's within this share of it.
pub const VOLUME_TOLERANCE: f64 = 1e-9;
/// Diagrams tried, each with sites shaken anew, before a cut is given up.
const ATTEMPTS: u64 = 3;
/// A part holds at least this many particles: one grid cell's worth at the usual density. Fewer do
/// not resolve the crack that cut it off (F32) ...
const FEWEST_PARTICLES: f64 = 8.0;
/// ... or, of drawn pieces, whose shape no particle tells, somewhat fewer than the smallest has.
const FEWEST_DRAWN: f64 = 2.0;
/// Shift of a site when a cut is tried again, in typical distances between sites.
const SHAKE: f64 = 1e-3;
/// The tag of a face that was there before any crack.
const OUTER: u32 = MAX_TAG;
/// Tags that the boolean kernel carries from a face to what is cut from it: below, a triangle of
/// the body; from here on, a facet of what cuts it.
const FACET: u32 = 1 << 30;
/// The box of [`by_sites`] reaches this share of the body's diagonal beyond it.
const BOX_MARGIN: f64 = 0.0317;

/// What a solver knows of the damage when it stops, in the reference configuration (body frame).
#[derive(Clone, Copy, Debug)]
pub struct DamageField<'a> {
    /// Grid spacing h \[m\].
    pub spacing: f64,
    /// Where each particle sat before the hit \[m\].
    pub positions: &'a [Vec3],
    /// Damage of each particle, in `[0, 1]`.
    pub damage: &'a [f64],
    /// When damage reached 1 \[s\]; infinite where it has not.
    pub damage_time: &'a [f64],
    /// Step of time in which it was found \[s\]; differences below it mean nothing (F35).
    pub time_step: f64,
    /// No front is faster \[m/s\].
    pub top_speed: f64,
    /// True length of a unit of this frame along each axis: 1, unless the frame is stretched.
    pub scale: Vec3,
    /// Unit normal of the crack at each broken particle, zero where it is not known; without it,
    /// cracks that end inside a part are not looked for.
    pub normals: Option<&'a [Vec3]>,
    /// The piece that each particle belongs to, and how those that were drawn were; without it,
    /// pieces are what the damage leaves connected on the lattice.
    pub pieces: Option<&'a Pieces>,
}

/// How fine a cut may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutSettings {
    /// Parts below this share of the body's volume join a neighbour \[1\].
    pub min_volume_ratio: f64,
    /// At most this many parts; the smallest join a neighbour first. Separate shells always stay.
    pub max_fragments: u32,
    /// The only source of randomness.
    pub seed: u64,
    /// How crack faces look closer up.
    pub detail: Detail,
}

/// One part of a body that was cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its closed boundary \[m\].
    pub solid: Solid,
    /// Convex parts that stand in for it in collisions: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// Its volume \[m³\].
    pub volume: f64,
    /// Cracks that end inside it.
    pub cracks: Vec<OpenCrack>,
}

/// A crack that ends inside a part, without junctions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenCrack {
    /// What of it lies inside the part \[m\].
    pub inside: Sheet,
    /// The same before it was clipped: it reaches out of the part where it meets its surface.
    pub beyond: Sheet,
}

/// A body taken apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Partition {
    /// By falling volume, then by centroid.
    pub parts: Vec<Part>,
    /// For each particle, the part it lies in: an index into `parts`.
    pub particle_part: Vec<u32>,
    /// Area of the new cracks \[m²\], counted once, not per side.
    pub crack_area: f64,
    /// How its faces lie in the grid of the solve, or in the lattice of the cut where they lie in
    /// that; of damage only.
    pub bias: GridBias,
    /// What was noticed and let pass, a sentence each.
    pub warnings: Vec<String>,
}

/// Why there is no cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CutError {
    /// The arrays differ in length or are empty.
    #[error("arrays of {counts:?} entries; all must have the same number, at least one")]
    Lengths {
        /// Entries in each, in the order of the arguments.
        counts: [usize; 3],
    },
    /// A number is not finite or out of range.
    #[error("{what} number {index} is not finite or out of range")]
    NotFinite {
        /// Which array.
        what: &'static str,
        /// Which entry.
        index: usize,
    },
    /// A limit would be exceeded.
    #[error("too large: {value:.3e} {what}, the limit is {limit:.3e}")]
    TooLarge {
        /// What there would be.
        what: &'static str,
        /// How many.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// The sites have no diagram.
    #[error(transparent)]
    Voronoi(#[from] VoronoiError),
    /// The boolean kernel refused.
    #[error(transparent)]
    Boolean(#[from] BooleanError),
    /// The faces show the grid.
    #[error("crack faces lie along the grid's planes {times:.1} times as often as chance (F22)")]
    Grid {
        /// How often, over chance \[1\].
        times: f64,
    },
    /// The parts do not add up.
    #[error(
        "{parts} parts enclose {sum:.12e} m³, the body {whole:.12e} m³; \
         at most {VOLUME_TOLERANCE:.0e} of it may be missing"
    )]
    Volume {
        /// How many parts.
        parts: usize,
        /// Their volume \[m³\].
        sum: f64,
        /// The body's \[m³\].
        whole: f64,
    },
}

impl CutError {
    /// Whether other jitter could help.
    fn is_accident(&self) -> bool {
        match self {
            Self::Voronoi(VoronoiError::Degenerate { .. })
            | Self::Boolean(_)
            | Self::Grid { .. }
            | Self::Volume { .. } => true,
            Self::Voronoi(_)
            | Self::Lengths { .. }
            | Self::NotFinite { .. }
            | Self::TooLarge { .. } => false,
        }
    }
}

/// Cuts a body along its damage. One part, the body untouched, if the damage does not go through.
///
/// # Errors
/// A field that is empty, uneven, not finite or too large; a solid that is not closed; a cut that
/// did not close or add up at every attempt.
pub fn extract(
    solid: &Solid,
    field: &DamageField<'_>,
    settings: &CutSettings,
) -> Result<Partition, CutError> {
    extract_stretched(solid, field, settings, &Vec3::repeat(1.0))
}

/// One attempt at [`extract`].
fn extract_once(
    solid: &Solid,
    field: &DamageField<'_>,
    settings: &CutSettings,
    way: &Way,
) -> Result<Partition, CutError> {
    let body = Body::new(solid, settings)?;
    let mut nodes = Nodes::new(&solid.mesh, field, &way.lattice)?;
    let (scale, top_speed) = (field.scale, field.top_speed);
    if nodes.labels() <= 1 {
        let mut whole = body.untouched(field.positions.len());
        if nodes.is_crushed() {
            whole.warnings.push("every lattice node is damaged: left whole".to_owned());
        } else {
            let ground = Ground { nodes: Arc::new(nodes), scale, top_speed };
            partial::attach(&mut whole.parts, field, &ground, &[vec![0]]);
        }
        return Ok(whole);
    }
    let drawn = field.pieces.is_some_and(|pieces| !pieces.rubble.balls.is_empty());
    let fewest = if drawn { FEWEST_DRAWN } else { FEWEST_PARTICLES };
    let share = fewest / field.positions.len() as f64;
    let floor = settings.min_volume_ratio.max(share) * body.volume;
    nodes.fill();
    merge_labels(&mut nodes, field, body.volume, floor, settings);
    let terms = ReliefTerms {
        detail: settings.detail,
        spacing: field.spacing,
        time_step: field.time_step,
        seed: scramble(settings.seed),
    };
    let ground = Ground { nodes: Arc::new(nodes), scale, top_speed };
    let mosaic = ground.nodes.mosaic(way.relief.then_some(&terms));
    let labels = (0..ground.nodes.labels()).collect();
    let bounds = (floor, settings.max_fragments);
    let mut cutting = Cutting::assemble(body, mosaic, labels, bounds, Some(ground.clone()))?;
    let mut partition = cutting.run()?;
    partition.particle_part = cutting.locate(field.positions, &partition.parts);
    partial::attach(&mut partition.parts, field, &ground, &cutting.part_labels);
    Ok(partition)
}

/// Cuts a body along the faces between the Voronoi cells of `sites` \[m\] that have different
/// `labels`; `times` \[s\] is when the crack passed each site. The caller brings the sites into
/// general position.
///
/// # Errors
/// As [`extract`].
pub fn by_sites(
    solid: &Solid,
    sites: &[Vec3],
    labels: &[u32],
    times: &[f64],
    settings: &CutSettings,
) -> Result<Partition, CutError> {
    attempts(|attempt| Cutting::begin(solid, sites, labels, times, settings, attempt)?.run())
}

/// What is said of a cut that was wanted with relief and came out without, at a later attempt.
fn unrelieved(settings: &CutSettings, attempt: u64) -> Option<String> {
    let lost = attempt > 0 && !settings.detail.is_none();
    lost.then(|| {
        format!("crack faces have no relief: only attempt {} at the cut closed", attempt + 1)
    })
}

/// Tries again with another jitter where that may help.
fn attempts<T>(mut cut: impl FnMut(u64) -> Result<T, CutError>) -> Result<T, CutError> {
    let mut attempt = 0;
    loop {
        attempt += 1;
        match cut(attempt - 1) {
            Err(error) if error.is_accident() && attempt < ATTEMPTS => {}
            other => return other,
        }
    }
}

/// The body that is cut.
#[derive(Clone, Debug)]
struct Body {
    solid: Solid,
    exact: Exact,
    volume: f64,
    area: f64,
    low: Vec3,
    high: Vec3,
}

impl Body {
    fn new(solid: &Solid, settings: &CutSettings) -> Result<Self, CutError> {
        if !(0.0..=1.0).contains(&settings.min_volume_ratio) {
            return Err(CutError::NotFinite { what: "least volume ratio in [0, 1]", index: 0 });
        }
        if let Some((what, ..)) = settings.detail.wrong() {
            return Err(CutError::NotFinite { what, index: 0 });
        }
        solid.validate().map_err(BooleanError::Mesh)?;
        let tag =
            |(t, surface): (usize, &Surface)| if surface.is_crack() { t as u32 } else { OUTER };
        let tags: Vec<u32> = solid.surface.iter().enumerate().map(tag).collect();
        let exact = Exact::tagged(&solid.mesh, &tags)?;
        let (low, high) = solid.mesh.bounds().unwrap_or_default();
        let (volume, area) = (solid.mesh.signed_volume(), solid.mesh.area());
        Ok(Self { solid: solid.clone(), exact, volume, area, low, high })
    }

    /// What a face with this tag and these corners was before the cut.
    fn surface_of(&self, tag: u32, corners: [Vec3; 3]) -> Surface {
        let Some(old) = self.solid.surface.get(tag as usize) else {
            return Surface::Outer;
        };
        old.within(self.solid.mesh.corners(tag as usize), corners)
    }

    fn untouched(self, particles: usize) -> Partition {
        let hulls = cutting::hulls(&self.solid);
        let (solid, volume) = (self.solid, self.volume);
        let part = Part { solid, hulls, volume, cracks: Vec::new() };
        Partition { parts: vec![part], particle_part: vec![0; particles], ..Default::default() }
    }
}

/// Gives small labels to their neighbours before anything is cut: cheap here, dear later. Volumes
/// are estimated by counting particles.
fn merge_labels(
    nodes: &mut Nodes,
    field: &DamageField<'_>,
    volume: f64,
    floor: f64,
    settings: &CutSettings,
) {
    let each = volume / field.positions.len() as f64;
    let mut volumes = vec![0.0; nodes.labels() as usize];
    for &place in field.positions {
        volumes[nodes.label_at(place) as usize] += each;
    }
    let forced = vec![false; volumes.len()];
    let max = settings.max_fragments.max(1) as usize;
    nodes.rename(&agglomerate(&volumes, &forced, &nodes.shared(), floor, max));
}

/// The sites of [`by_sites`] in a box around the body and them, shaken from the second attempt on.
fn boxed(
    body: &Body,
    places: &[Vec3],
    labels: &[u32],
    times: &[f64],
    seed: u64,
    attempt: u64,
) -> Result<Cells, CutError> {
    let counts = [places.len(), labels.len(), times.len()];
    if counts.contains(&0) || counts[0] != counts[1] || counts[0] != counts[2] {
        return Err(CutError::Lengths { counts });
    }
    if let Some(index) = places.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(CutError::NotFinite { what: "site", index });
    }
    if let Some(index) = times.iter().position(|t| t.is_nan() || *t < 0.0) {
        return Err(CutError::NotFinite { what: "damage time of site", index });
    }
    let low = places.iter().fold(body.low, |a, p| a.inf(p));
    let high = places.iter().fold(body.high, |a, p| a.sup(p));
    let margin = Vec3::repeat(BOX_MARGIN * (high - low).norm());
    let (low, high) = (low - margin, high + margin);
    let extent = high - low;
    let width = libm::cbrt(extent.x * extent.y * extent.z / places.len() as f64);
    let shake = if attempt == 0 { 0.0 } else { SHAKE * width.min(margin.x) };
    let shaken = places.iter().enumerate().map(|(i, p)| {
        let key = scramble(seed).wrapping_add(attempt);
        let at = |k| shake * (2.0 * unit(key, k, i as u64) - 1.0);
        p + Vec3::new(at(0), at(1), at(2))
    });
    Ok(Cells::new(shaken.collect(), low, high)?)
}
