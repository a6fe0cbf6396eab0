//! Cuts that are tried again: where one does not close, or its faces show the grid (F22, F26).
//!
//! A lattice that is turned out of the grid's axes has nothing in common with them nor with faces
//! of the body along them, and a finer one has smaller steps; faces without relief cross least.

use super::once::CutAttempt;
use super::partition::{CutSettings, Partition};
use super::stretched;
use crate::crack::{BROKEN, LatticeChoice};
use crate::error::CutError;
use crate::field::DamageField;
use crate::grid_bias::{GridBias, grid_bias, turn};
use cullet_geometry::math::scramble;
use cullet_geometry::{Mat3, Solid, Vec3};

/// Stream of the seed's numbers.
const STREAM: u64 = 0xa6a1;

/// What is changed from one attempt to the next.
#[derive(Clone, Copy, Debug)]
struct RetryStep {
    turned: bool,
    refinement: f64,
    relief: bool,
}

/// The attempts, the most wanted first.
const STEPS: [RetryStep; 6] = [
    RetryStep { turned: false, refinement: 1.0, relief: true },
    RetryStep { turned: true, refinement: 1.0, relief: true },
    RetryStep { turned: true, refinement: 1.0, relief: false },
    RetryStep { turned: true, refinement: 0.7, relief: true },
    RetryStep { turned: true, refinement: 0.7, relief: false },
    RetryStep { turned: true, refinement: 0.8, relief: false },
];

/// Cuts a body along its damage; see [`super::extract`]. Each axis is stretched by `stretch` \[1\]
/// before: the field's spacing is that of the cubes there, its positions are the body's own.
///
/// The cut that shows the grid least, where all do: its [`Partition::bias`] tells.
///
/// # Errors
/// As [`super::extract`].
pub fn extract_stretched(
    solid: &Solid,
    field: &DamageField<'_>,
    settings: &CutSettings,
    stretch: &Vec3,
) -> Result<Partition, CutError> {
    let broken = broken(field);
    let (mut first, mut best): (Option<CutError>, Option<Partition>) = (None, None);
    for (k, step) in STEPS.iter().enumerate() {
        let axes = match step.turned {
            true => turn(scramble(settings.seed ^ STREAM), k as u64),
            false => Mat3::identity(),
        };
        let lattice = LatticeChoice { axes, refinement: step.refinement };
        let attempt = CutAttempt { lattice, relief: step.relief };
        match stretched::attempt(solid, field, settings, stretch, &attempt) {
            Ok(mut partition) => {
                partition.bias = bias(&partition, field, &broken, (&axes, stretch));
                partition.warnings.extend(first.iter().map(|why| again(k, step, why)));
                if !partition.bias.shows() {
                    return Ok(partition);
                }
                let times = partition.bias.times;
                first.get_or_insert(CutError::Grid { times });
                best = best.filter(|best| best.bias.times <= times).or(Some(partition));
            }
            Err(error) if error.is_accident() => {
                first.get_or_insert(error);
            }
            Err(error) => return Err(error),
        }
    }
    // What the first attempt failed of is what is wrong: the others were to help.
    best.ok_or_else(|| first.unwrap_or(CutError::Grid { times: 0.0 }))
}

/// The directions across which points broke, where the field knows them.
fn broken(field: &DamageField<'_>) -> Vec<Vec3> {
    let normals = field.normals.into_iter().flatten();
    let known = normals.zip(field.damage).zip(field.positions);
    let free = known.filter(|((_, damage), place)| **damage >= BROKEN && !is_scored(field, place));
    free.map(|((normal, _), _)| *normal).collect()
}

/// Whether a place is within a spacing of a scored groove.
fn is_scored(field: &DamageField<'_>, place: &Vec3) -> bool {
    field.scored.iter().any(|groove| groove.contains(place, field.spacing))
}

/// How the faces of a cut lie in the grid of the solve and in the lattice of the cut: the figure of
/// the one that shows, or of the grid. Faces in scored grooves lie as the scene asks, and are not
/// counted.
fn bias(
    partition: &Partition,
    field: &DamageField<'_>,
    broken: &[Vec3],
    (axes, stretch): (&Mat3, &Vec3),
) -> GridBias {
    let solids = || partition.parts.iter().map(|part| &part.solid);
    let grid_bias = |planes| {
        let counts = |place: &Vec3| !is_scored(field, place);
        grid_bias(solids(), counts, broken, planes)
    };
    let grid = grid_bias([Vec3::x(), Vec3::y(), Vec3::z()]);
    if grid.shows() || *axes == Mat3::identity() {
        return grid;
    }
    // A plane of the stretched frame with normal n has the normal S n here.
    let plane = |k: usize| stretch.component_mul(&axes.column(k)).normalize();
    let lattice = grid_bias([plane(0), plane(1), plane(2)]);
    if lattice.shows() { lattice } else { grid }
}

/// What is said of a cut that was tried again.
fn again(attempt: usize, step: &RetryStep, why: &CutError) -> String {
    let finer = if step.refinement < 1.0 { "finer, " } else { "" };
    let relief = if step.relief { "" } else { ", without relief" };
    format!("cut again on a {finer}turned lattice{relief}, attempt {}: {why}", attempt + 1)
}
