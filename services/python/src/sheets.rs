//! Bodies that move as they deform: where their points are, and what came of their windows.

use crate::buffers::Columns;
use crate::errors::of_record;
use crate::happenings::figures;
use cullet::Recording;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Sheets by number, with the times of their frames.
pub(crate) fn list<'py>(py: Python<'py>, recording: &Recording) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    for sheet in recording.sheets() {
        let columns = Columns::new(py);
        columns.numbers("step", sheet.frames.iter().map(|frame| frame.step))?;
        columns.numbers("time", sheet.frames.iter().map(|frame| frame.time))?;
        let told = columns.done();
        told.set_item("number", sheet.number)?;
        told.set_item("name", sheet.name)?;
        told.set_item("material", sheet.material)?;
        all.append(told)?;
    }
    Ok(all)
}

/// A sheet at its last frame up to a step.
pub(crate) fn moment<'py>(
    py: Python<'py>,
    recording: &Recording,
    sheet: u32,
    step: u64,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(moment) = recording.sheet_at(sheet, step).map_err(of_record(py))? else {
        return Ok(None);
    };
    let columns = Columns::new(py);
    columns.numbers("vertices", moment.places.iter().flatten().copied())?;
    columns.numbers("triangles", moment.surface.triangles.iter().flatten().copied())?;
    columns.numbers("reference", moment.surface.reference.iter().flatten().copied())?;
    columns.numbers("quantity", moment.quantity.iter().copied())?;
    let told = columns.done();
    told.set_item("thickness", moment.surface.thickness)?;
    told.set_item("step", moment.at.step)?;
    told.set_item("time", moment.at.time)?;
    Ok(Some(told))
}

/// What came of each window, in order of time.
pub(crate) fn windows<'py>(
    py: Python<'py>,
    recording: &Recording,
    sheet: u32,
) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    for sound in recording.windows_of(sheet).map_err(of_record(py))? {
        let told = PyDict::new(py);
        told.set_item("first_step", sound.window.first_step)?;
        told.set_item("steps", sound.window.steps)?;
        told.set_item("time", sound.window.time)?;
        told.set_item("gap", sound.window.gap)?;
        told.set_item("solved", sound.window.solved)?;
        told.set_item("one_way", sound.window.one_way)?;
        let ledger = PyDict::new(py);
        for (name, value) in sound.ledger.numbers() {
            ledger.set_item(name, value)?;
        }
        told.set_item("ledger", ledger)?;
        let pieces = PyList::empty(py);
        for piece in &sound.pieces {
            let of = PyDict::new(py);
            of.set_item("number", piece.number)?;
            of.set_item("parent", piece.parent)?;
            of.set_item("born", piece.born)?;
            of.set_item("mass", piece.mass)?;
            of.set_item("area", piece.area)?;
            of.set_item("frozen", piece.frozen)?;
            pieces.append(of)?;
        }
        told.set_item("pieces", pieces)?;
        told.set_item("figures", figures(py, &sound.window.figures)?)?;
        told.set_item("warnings", &sound.window.warnings)?;
        all.append(told)?;
    }
    Ok(all)
}
