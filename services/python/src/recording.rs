//! A recording: its bodies, where they are, their meshes, and what is made of it.

use crate::buffers::Columns;
use crate::errors::{of_record, of_recording};
use crate::happenings;
use crate::pose_rows;
use crate::sheets;
use cullet::geometry::{Solid, Surface};
use cullet::messages::{Body, EventKind};
use cullet::picture::{Framing, Still, StillTime, still};
use cullet::record::{FragmentMass, fit, masses};
use cullet::{ExportOptions, Moments, Recording, export};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A step that is later than any.
const LAST: u64 = u64::MAX;

/// What a recording holds, in memory.
#[pyclass(name = "Recording", module = "cullet._cullet", frozen)]
#[derive(Debug)]
pub(crate) struct PyRecording {
    recording: Arc<Recording>,
}

#[pymethods]
impl PyRecording {
    #[new]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = py.detach(|| Recording::open(&path)).map_err(of_record(py))?;
        Ok(Self { recording: Arc::new(read) })
    }

    #[getter]
    fn path(&self) -> &Path {
        &self.recording.path
    }

    #[getter]
    fn complete(&self) -> bool {
        self.recording.complete
    }

    #[getter]
    fn damaged(&self) -> bool {
        self.recording.damaged
    }

    /// What is missing in it, in words.
    #[getter]
    fn missing(&self) -> Option<String> {
        let holes = &self.recording.holes;
        (!holes.is_empty()).then(|| holes.to_string())
    }

    #[getter]
    fn meta(&self) -> BTreeMap<String, String> {
        self.recording.meta.clone()
    }

    /// The summary as JSON.
    fn summary(&self, py: Python<'_>) -> String {
        py.detach(|| self.recording.summary().to_json())
    }

    fn attachments(&self) -> Vec<&str> {
        self.recording.attachments.keys().map(String::as_str).collect()
    }

    fn attachment<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyBytes>> {
        self.recording.attachments.get(name).map(|bytes| PyBytes::new(py, bytes))
    }

    /// Bodies in order of birth.
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let bodies = || self.recording.bodies.iter();
        let columns = Columns::new(py);
        columns.numbers("body", bodies().map(|body| body.id))?;
        columns.texts("name", bodies().map(|body| &body.name))?;
        columns.texts("object", bodies().map(|body| &body.object))?;
        let parent = |body: &Body| body.parent.map_or(-1, |parent| parent as i64);
        columns.numbers("parent", bodies().map(parent))?;
        columns.numbers("generation", bodies().map(|body| body.generation))?;
        columns.texts("tier", bodies().map(|body| happenings::word(body.tier())))?;
        columns.texts("made", self.made())?;
        columns.texts("material", bodies().map(|body| &body.material))?;
        columns.numbers("mass", bodies().map(|body| body.mass))?;
        columns.numbers("volume", bodies().map(|body| body.volume))?;
        columns.numbers("fixed", bodies().map(|body| body.fixed))?;
        columns.numbers("birth_step", bodies().map(|body| body.birth_step))?;
        let ends = self.ends();
        let end = |body: &Body| ends.get(&body.id).map_or(-1, |step| *step as i64);
        columns.numbers("end_step", bodies().map(end))?;
        let spacing = self.recording.spacings();
        let of = |body: &Body| body.parent.and_then(|it| spacing.get(&it)).copied();
        columns.numbers("spacing", bodies().map(|body| of(body).unwrap_or(0.0)))?;
        Ok(columns.done())
    }

    /// Every row of the pose track.
    fn pose_rows<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        pose_rows::rows(py, &self.recording.poses)
    }

    /// The grains of debris after so many steps.
    fn grains<'py>(&self, py: Python<'py>, step: u64) -> PyResult<Bound<'py, PyDict>> {
        pose_rows::grains(py, &self.recording, step)
    }

    /// Where each body lay in the object of the scene that it comes from.
    fn rest<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let places = py.detach(|| self.recording.rest_places());
        let columns = Columns::new(py);
        columns.numbers("body", places.keys().copied())?;
        columns.numbers("root", places.values().map(|place| place.root))?;
        let origin = places.values().flat_map(|place| -> [f64; 3] { place.origin.into() });
        columns.numbers("origin", origin)?;
        Ok(columns.done())
    }

    /// The mesh that a body has after so many steps; without a number at its birth.
    fn mesh<'py>(
        &self,
        py: Python<'py>,
        body: u64,
        step: Option<u64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let unknown = || of_recording(py, &format!("there is no body {body} in the recording"));
        let body = self.recording.body(body).ok_or_else(unknown)?;
        let solid = match step.and_then(|step| self.recording.geometry_of(body.id, step)) {
            None => self.recording.mesh(body),
            Some(geometry) => {
                self.recording.mesh(&Body { geometry: geometry.to_vec(), ..body.clone() })
            }
        };
        columns_of(py, &solid.map_err(of_record(py))?)
    }

    /// New shapes of bodies that were deformed.
    fn shapes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let shapes = || self.recording.shapes.iter();
        let columns = Columns::new(py);
        columns.numbers("body", shapes().map(|shape| shape.body))?;
        columns.numbers("step", shapes().map(|shape| shape.step))?;
        columns.numbers("time", shapes().map(|shape| shape.time))?;
        columns.numbers("mass", shapes().map(|shape| shape.mass))?;
        columns.numbers("volume", shapes().map(|shape| shape.volume))?;
        Ok(columns.done())
    }

    /// Cracks that end inside a body, as open surfaces, up to a step.
    fn cracks<'py>(
        &self,
        py: Python<'py>,
        body: u64,
        step: Option<u64>,
    ) -> PyResult<Bound<'py, PyList>> {
        let step = step.unwrap_or(LAST);
        let own = self.recording.cracks.iter().filter(|it| it.body == body && it.step <= step);
        let all = PyList::empty(py);
        for crack in own {
            let columns = Columns::new(py);
            columns.numbers("vertices", crack.vertices.iter().copied())?;
            columns.numbers("triangles", crack.triangles.iter().copied())?;
            columns.numbers("damage_time", crack.damage_time.iter().copied())?;
            columns.numbers("front_speed", crack.front_speed.iter().copied())?;
            let told = columns.done();
            told.set_item("step", crack.step)?;
            told.set_item("time", crack.time)?;
            all.append(told)?;
        }
        Ok(all)
    }

    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        happenings::events(py, &self.recording)
    }

    fn reports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        happenings::reports(py, &self.recording)
    }

    fn fractures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        happenings::fractures(py, &self.recording)
    }

    fn sheets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        sheets::list(py, &self.recording)
    }

    fn sheet_at<'py>(
        &self,
        py: Python<'py>,
        sheet: u32,
        step: u64,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        sheets::moment(py, &self.recording, sheet, step)
    }

    fn windows<'py>(&self, py: Python<'py>, sheet: u32) -> PyResult<Bound<'py, PyList>> {
        sheets::windows(py, &self.recording, sheet)
    }

    /// Fragments that broke no further.
    fn fragment_masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let path = &self.recording.path;
        let all = py.detach(|| masses(path)).map_err(of_record(py))?;
        let columns = Columns::new(py);
        columns.texts("name", all.iter().map(|part| &part.name))?;
        columns.texts("object", all.iter().map(|part| &part.object))?;
        columns.numbers("generation", all.iter().map(|part| part.generation))?;
        columns.numbers("mass", all.iter().map(|part| part.mass))?;
        columns.numbers("ratio", all.iter().map(|part| part.ratio))?;
        columns.numbers("cell", all.iter().map(|part| part.cell))?;
        columns.texts("made", all.iter().map(FragmentMass::made))?;
        Ok(columns.done())
    }

    /// Draws a moment into a file; hands back which. `close`: the body to draw, or an empty text
    /// for what breaks.
    fn still(
        &self,
        py: Python<'_>,
        path: PathBuf,
        time: Option<f64>,
        size: (usize, usize),
        close: Option<&str>,
    ) -> PyResult<f64> {
        let time = time.map_or(StillTime::Telling, StillTime::At);
        let framing = close.map_or(Framing::Whole, Framing::of_close);
        let wanted = Still { time, size, framing };
        let recording = &self.recording;
        py.detach(|| still(recording, &wanted, &path)).map_err(of_record(py))
    }

    /// Writes the recording for another program; hands back the files and what is in them as JSON.
    fn export(
        &self,
        py: Python<'_>,
        path: PathBuf,
        fps: f64,
        span: (Option<f64>, Option<f64>),
        at: Option<f64>,
        grains: bool,
    ) -> PyResult<String> {
        let moments = at.map_or(Moments::Motion, Moments::At);
        let options = ExportOptions { fps, start: span.0, end: span.1, moments, grains };
        let report = py.detach(|| export(&self.recording, &options, &path));
        let report = report.map_err(|error| of_recording(py, &error))?;
        serde_json::to_string(&report).map_err(|error| of_recording(py, &error))
    }
}

impl PyRecording {
    /// The step at which each body broke or left.
    fn ends(&self) -> BTreeMap<u64, u64> {
        let gone = |kind| matches!(kind, EventKind::Fractured | EventKind::Removed);
        let ends = self.recording.events.iter().filter(|event| gone(event.kind()));
        ends.filter_map(|event| Some((event.body?, event.step))).collect()
    }

    /// Whether each body was given by the scene, solved, sampled or directed, or whether that is
    /// not told.
    fn made(&self) -> Vec<&'static str> {
        let origins = self.recording.origins();
        let of = |body: &Body| match body.parent {
            None => "given",
            Some(_) => origins.get(&body.id).map_or("unknown", |origin| origin.word()),
        };
        self.recording.bodies.iter().map(of).collect()
    }
}

fn columns_of<'py>(py: Python<'py>, solid: &Solid) -> PyResult<Bound<'py, PyDict>> {
    let columns = Columns::new(py);
    columns.numbers("vertices", solid.mesh.vertices.iter().flatten().copied())?;
    columns.numbers("triangles", solid.mesh.triangles.iter().flatten().copied())?;
    let is_crack = |surface: &Surface| matches!(surface, Surface::Crack { .. });
    columns.numbers("crack", solid.surface.iter().map(is_crack))?;
    let marks = |surface: &Surface| match surface {
        Surface::Outer => ([f32::NAN; 3], [f32::NAN; 3]),
        Surface::Crack { damage_time, front_speed, .. } => (*damage_time, *front_speed),
    };
    columns.numbers("damage_time", solid.surface.iter().flat_map(|it| marks(it).0))?;
    columns.numbers("front_speed", solid.surface.iter().flat_map(|it| marks(it).1))?;
    Ok(columns.done())
}

/// Mott's law and a power law fitted to masses of at least `least`; nothing for fewer than three.
#[pyfunction]
pub(crate) fn fit_masses<'py>(
    py: Python<'py>,
    masses: Vec<f64>,
    least: f64,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(fits) = fit(&masses, least) else { return Ok(None) };
    let told = PyDict::new(py);
    told.set_item("count", fits.count)?;
    told.set_item("least", fits.least)?;
    told.set_item("mott_mass", fits.mott.value)?;
    told.set_item("mott_count", fits.whole)?;
    told.set_item("mott_distance", fits.mott.distance)?;
    told.set_item("power_exponent", fits.power.value)?;
    told.set_item("power_distance", fits.power.distance)?;
    Ok(Some(told))
}
