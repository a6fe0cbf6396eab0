//! The pose track and the grains of a recording as columns.

use crate::buffers::Columns;
use cullet::Recording;
use cullet::messages::{BodyPoses, Grains};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// Every row of the track, in order.
pub(crate) fn rows<'py>(py: Python<'py>, poses: &[BodyPoses]) -> PyResult<Bound<'py, PyDict>> {
    let columns = Columns::new(py);
    let each = |poses: &BodyPoses| poses.ids.len();
    columns.numbers("step", poses.iter().flat_map(|p| std::iter::repeat_n(p.step, each(p))))?;
    columns.numbers("time", poses.iter().flat_map(|p| std::iter::repeat_n(p.time, each(p))))?;
    columns.numbers("body", poses.iter().flat_map(|p| p.ids.iter().copied()))?;
    columns.numbers("position", poses.iter().flat_map(|p| p.positions.iter().copied()))?;
    columns.numbers("rotation", poses.iter().flat_map(|p| p.rotations.iter().copied()))?;
    columns.numbers("velocity", poses.iter().flat_map(|p| p.velocities.iter().copied()))?;
    columns.numbers("spin", poses.iter().flat_map(|p| p.spins.iter().copied()))?;
    Ok(columns.done())
}

/// A grain: where it is, and what was told at its birth.
struct GrainMoment {
    position: [f64; 3],
    velocity: [f64; 3],
    mass: f64,
    size: f64,
    parent: u64,
}

/// The grains that are there after so many steps, by number.
pub(crate) fn grains<'py>(
    py: Python<'py>,
    recording: &Recording,
    step: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let all = py.detach(|| {
        let mut all = BTreeMap::new();
        let until = recording.debris.iter().take_while(|rows| rows.step <= step);
        until.for_each(|rows| take(&mut all, rows));
        all
    });
    let columns = Columns::new(py);
    columns.numbers("grain", all.keys().copied())?;
    columns.numbers("position", all.values().flat_map(|grain| grain.position))?;
    columns.numbers("velocity", all.values().flat_map(|grain| grain.velocity))?;
    columns.numbers("mass", all.values().map(|grain| grain.mass))?;
    columns.numbers("size", all.values().map(|grain| grain.size))?;
    columns.numbers("parent", all.values().map(|grain| grain.parent))?;
    Ok(columns.done())
}

/// Rows of a step; new grains come with mass, size and parent, in the order of their rows.
fn take(all: &mut BTreeMap<u64, GrainMoment>, rows: &Grains) {
    let mut new = rows.masses.iter().zip(&rows.sizes).zip(&rows.parents);
    let places = rows.positions.as_chunks::<3>().0.iter().zip(rows.velocities.as_chunks::<3>().0);
    for (&id, (&position, &velocity)) in rows.ids.iter().zip(places) {
        if let Some(grain) = all.get_mut(&id) {
            (grain.position, grain.velocity) = (position, velocity);
        } else if let Some(((&mass, &size), &parent)) = new.next() {
            all.insert(id, GrainMoment { position, velocity, mass, size, parent });
        }
    }
}
