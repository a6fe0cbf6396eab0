//! What happened in a run: events, job reports, fractures, each as a dictionary.

use cullet::Recording;
use cullet::messages::{EventKind, Hit, JobReport, Ledger, ReportFigure, RunEvent, Vector3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::collections::BTreeMap;

/// The word of a value of an enumeration: `job_settled` for `JobSettled`.
pub(crate) fn word(value: impl std::fmt::Debug) -> String {
    let mut word = String::new();
    for c in format!("{value:?}").chars() {
        if c.is_uppercase() && !word.is_empty() {
            word.push('_');
        }
        word.extend(c.to_lowercase());
    }
    word
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn point(at: Option<&Vector3>) -> Option<(f64, f64, f64)> {
    at.map(|at| (at.x, at.y, at.z))
}

/// Events in order.
pub(crate) fn events<'py>(py: Python<'py>, recording: &Recording) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    for event in &recording.events {
        all.append(of_event(py, event)?)?;
    }
    Ok(all)
}

fn of_event<'py>(py: Python<'py>, event: &RunEvent) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("kind", word(event.kind()))?;
    told.set_item("step", event.step)?;
    told.set_item("time", event.time)?;
    told.set_item("body", event.body)?;
    match event.kind() {
        EventKind::Impact => {
            told.set_item("striker", event.striker)?;
            told.set_item("point", point(event.point.as_ref()))?;
            told.set_item("impulse", event.impulse)?;
            told.set_item("closing_speed", event.closing_speed)?;
            told.set_item("energy", event.energy)?;
            told.set_item("duration", event.duration)?;
            told.set_item("radius", event.radius)?;
            told.set_item("peak_force", event.peak_force)?;
            told.set_item("dissipated", event.dissipated)?;
        }
        EventKind::Fractured => {
            told.set_item("fragments", &event.fragments)?;
            told.set_item("grains", event.grains)?;
            told.set_item("grain_mass", event.grain_mass)?;
            told.set_item("alpha", event.alpha)?;
            told.set_item("ledger", ledger(py, event.ledger.as_ref())?)?;
        }
        EventKind::JobSettled => {
            told.set_item("verdict", word(event.verdict()))?;
        }
        EventKind::JointBroken => {
            told.set_item("joint", event.joint)?;
            told.set_item("other", event.striker)?;
            told.set_item("point", point(event.point.as_ref()))?;
            told.set_item("force", event.force)?;
            told.set_item("torque", event.torque)?;
            told.set_item("load_share", event.load_share)?;
        }
        EventKind::JointGone => {
            told.set_item("joint", event.joint)?;
            told.set_item("other", event.striker)?;
        }
        EventKind::Driven => told.set_item("work", event.energy)?,
        EventKind::Expectation => told.set_item("held", event.held)?,
        EventKind::Deformed => told.set_item("ledger", ledger(py, event.ledger.as_ref())?)?,
        _ => {}
    }
    if !event.job.is_empty() {
        told.set_item("job", hex(&event.job))?;
    }
    if !event.text.is_empty() {
        told.set_item("text", &event.text)?;
    }
    Ok(told)
}

fn ledger<'py>(py: Python<'py>, of: Option<&Ledger>) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(of) = of else { return Ok(None) };
    let told = PyDict::new(py);
    told.set_item("mass_rel_error", of.mass_rel_error)?;
    told.set_item("volume_rel_error", of.volume_rel_error)?;
    told.set_item("momentum_rel_error", of.momentum_rel_error)?;
    told.set_item("angular_momentum_rel_error", of.angular_momentum_rel_error)?;
    told.set_item("energy_before", of.energy_before)?;
    told.set_item("energy_after", of.energy_after)?;
    told.set_item("fracture_energy", of.fracture_energy)?;
    told.set_item("energy_gain_rel", of.energy_gain_rel)?;
    Ok(Some(told))
}

/// How each job came out.
pub(crate) fn reports<'py>(py: Python<'py>, recording: &Recording) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    for report in &recording.reports {
        all.append(of_report(py, report)?)?;
    }
    Ok(all)
}

fn of_report<'py>(py: Python<'py>, report: &JobReport) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("job", hex(&report.job))?;
    told.set_item("body", report.body)?;
    told.set_item("asked", &report.asked)?;
    told.set_item("solver", &report.solver)?;
    told.set_item("verdict", word(report.verdict()))?;
    told.set_item("refusal", &report.refusal)?;
    told.set_item("fragments", report.fragments)?;
    told.set_item("spacing", report.spacing)?;
    told.set_item("particles", report.particles)?;
    told.set_item("steps", report.steps)?;
    told.set_item("simulated", report.simulated)?;
    told.set_item("crack_area", report.crack_area)?;
    told.set_item("fracture_energy", report.fracture_energy)?;
    told.set_item("dissipated_energy", report.dissipated_energy)?;
    told.set_item("strength_ratio", report.strength_ratio)?;
    told.set_item("damaged_fraction", report.damaged_fraction)?;
    told.set_item("delivered_impulse", report.delivered_impulse)?;
    told.set_item("warnings", &report.warnings)?;
    told.set_item("figures", figures(py, &report.details)?)?;
    let hits = PyList::empty(py);
    for hit in &report.hits {
        hits.append(of_hit(py, hit)?)?;
    }
    told.set_item("hits", hits)?;
    Ok(told)
}

fn of_hit<'py>(py: Python<'py>, hit: &Hit) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("point", point(hit.point.as_ref()))?;
    told.set_item("normal", point(hit.normal.as_ref()))?;
    told.set_item("impulse", hit.impulse)?;
    told.set_item("duration", hit.duration)?;
    told.set_item("radius", hit.radius)?;
    told.set_item("energy", hit.energy)?;
    told.set_item("closing_speed", hit.closing_speed)?;
    Ok(told)
}

/// What only a family knows: value and unit by name.
pub(crate) fn figures<'py>(
    py: Python<'py>,
    figures: &[ReportFigure],
) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    for figure in figures {
        told.set_item(&figure.name, (figure.value, &figure.unit))?;
    }
    Ok(told)
}

/// Each fracture, with how much of it was solved, sampled and directed.
pub(crate) fn fractures<'py>(
    py: Python<'py>,
    recording: &Recording,
) -> PyResult<Bound<'py, PyList>> {
    let sampled: BTreeMap<_, _> = recording.sampled.iter().map(|of| (of.body, of)).collect();
    let all = PyList::empty(py);
    for event in recording.events.iter().filter(|event| event.kind() == EventKind::Fractured) {
        let told = of_event(py, event)?;
        let of = event.body.and_then(|body| sampled.get(&body));
        told.set_item("sampled_fragments", of.map(|of| &of.fragments))?;
        told.set_item("solved_volume", of.map(|of| of.solved_volume))?;
        told.set_item("sampled_volume", of.map(|of| of.sampled_volume))?;
        told.set_item("solved_crack_area", of.map(|of| of.solved_crack_area))?;
        told.set_item("sampled_crack_area", of.map(|of| of.sampled_crack_area))?;
        told.set_item("directed_fragments", of.map(|of| &of.directed))?;
        told.set_item("directed_volume", of.map(|of| of.directed_volume))?;
        told.set_item("directed_crack_area", of.map(|of| of.directed_crack_area))?;
        all.append(told)?;
    }
    Ok(all)
}
