//! One attempt at a cut along damage.

use super::body::CutBody;
use super::cutting::Cutting;
use super::ground::Ground;
use super::partial;
use super::partition::{CutSettings, Partition};
use crate::crack::{LatticeChoice, LatticeNodes};
use crate::error::CutError;
use crate::field::DamageField;
use crate::region::agglomerate;
use crate::region::terms::ReliefTerms;
use cullet_geometry::Solid;
use cullet_geometry::math::scramble;
use std::sync::Arc;

/// A part holds at least this many particles: one grid cell's worth at the usual density. Fewer do
/// not resolve the crack that cut it off (F32) ...
const FEWEST_PARTICLES: f64 = 8.0;
/// ... or, of sampled pieces, whose shape no particle tells, somewhat fewer than the smallest has.
const FEWEST_DRAWN: f64 = 2.0;

/// How a body is cut at one attempt.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutAttempt {
    /// The lattice that labels are spread on.
    pub(super) lattice: LatticeChoice,
    /// Whether crack faces get relief.
    pub(super) relief: bool,
}

/// One attempt at [`super::extract`], in a frame that is not stretched.
pub(super) fn extract_once(
    solid: &Solid,
    field: &DamageField<'_>,
    settings: &CutSettings,
    attempt: &CutAttempt,
) -> Result<Partition, CutError> {
    let body = CutBody::new(solid, settings)?;
    let mut nodes = LatticeNodes::new(&solid.mesh, field, &attempt.lattice)?;
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
    let mosaic = ground.nodes.mosaic(attempt.relief.then_some(&terms));
    let labels = (0..ground.nodes.labels()).collect();
    let bounds = (floor, settings.max_fragments);
    let mut cutting = Cutting::assemble(body, mosaic, labels, bounds, Some(ground.clone()))?;
    let mut partition = cutting.run()?;
    partition.particle_part = cutting.locate(field.positions, &partition.parts);
    partial::attach(&mut partition.parts, field, &ground, &cutting.part_labels);
    Ok(partition)
}

/// Gives small labels to their neighbours before anything is cut: cheap here, dear later. Volumes
/// are estimated by counting particles.
fn merge_labels(
    nodes: &mut LatticeNodes,
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
