//! Scenes: read, set, checked.

use crate::buffers::Columns;
use crate::errors::of_scene;
use cullet::document::SceneFile;
use cullet::scene::{SceneMovingBody, presets_json};
use cullet::{Bundle, Scene};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Where a scene comes from, to read it again with other values.
#[derive(Clone, Debug)]
enum SceneOrigin {
    /// A file or its folder.
    Path(PathBuf),
    /// A text with files, in the folder or in no folder.
    Text { name: String, text: String, files: BTreeMap<String, Vec<u8>>, folder: Option<PathBuf> },
}

impl SceneOrigin {
    fn read(&self, set: &[String]) -> Result<Scene, cullet::SceneErrors> {
        match self {
            Self::Path(path) => Scene::load(path, set),
            Self::Text { name, text, files, folder } => {
                let file = |(key, bytes): (&String, &Vec<u8>)| SceneFile {
                    key: format!("scene/{key}"),
                    bytes: Arc::new(bytes.clone()),
                };
                let files = files.iter().map(file).collect();
                Scene::assemble(name, text, files, folder.as_deref(), set)
            }
        }
    }
}

/// A scene that was read and checked.
#[pyclass(name = "Scene", module = "cullet._cullet", frozen)]
#[derive(Debug)]
pub(crate) struct PyScene {
    pub(crate) scene: Arc<Scene>,
    origin: SceneOrigin,
}

impl PyScene {
    fn of(py: Python<'_>, origin: SceneOrigin, set: &[String]) -> PyResult<Self> {
        let scene = py.detach(|| origin.read(set)).map_err(|errors| of_scene(py, &errors))?;
        Ok(Self { scene: Arc::new(scene), origin })
    }

    pub(crate) fn bundle(&self) -> Bundle {
        self.scene.bundle()
    }
}

#[pymethods]
impl PyScene {
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, set: Vec<String>) -> PyResult<Self> {
        Self::of(py, SceneOrigin::Path(path), &set)
    }

    #[staticmethod]
    fn parse(
        py: Python<'_>,
        name: String,
        text: String,
        files: BTreeMap<String, Vec<u8>>,
        folder: Option<PathBuf>,
        set: Vec<String>,
    ) -> PyResult<Self> {
        Self::of(py, SceneOrigin::Text { name, text, files, folder }, &set)
    }

    /// The same scene with more values set.
    fn set(&self, py: Python<'_>, set: Vec<String>) -> PyResult<Self> {
        let set = [&self.scene.overrides[..], &set[..]].concat();
        Self::of(py, self.origin.clone(), &set)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    #[getter]
    fn description(&self) -> &str {
        &self.scene.description
    }

    #[getter]
    fn duration(&self) -> f64 {
        self.scene.world.duration
    }

    #[getter]
    fn step(&self) -> f64 {
        self.scene.world.step
    }

    #[getter]
    fn steps(&self) -> u64 {
        self.scene.steps()
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.scene.world.seed
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.warnings.clone()
    }

    #[getter]
    fn overrides(&self) -> Vec<String> {
        self.scene.overrides.clone()
    }

    #[getter]
    fn text(&self) -> &str {
        &self.scene.source_text
    }

    /// Rigid bodies, in order.
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let bodies = || self.scene.bodies.iter();
        let columns = Columns::new(py);
        columns.texts("name", bodies().map(|body| &body.name))?;
        columns.texts("material", bodies().map(|body| &body.material.name))?;
        columns.numbers("mass", bodies().map(|body| body.volume * body.material.density))?;
        columns.numbers("volume", bodies().map(|body| body.volume))?;
        columns.numbers("fixed", bodies().map(|body| body.fixed))?;
        columns.numbers("breakable", bodies().map(|body| body.breakable))?;
        let triangles = |body: &cullet::SceneBody| body.solid.mesh.triangles.len() as u64;
        columns.numbers("triangles", bodies().map(triangles))?;
        let position =
            |body: &cullet::SceneBody| -> [f64; 3] { body.pose.translation.vector.into() };
        columns.numbers("position", bodies().flat_map(position))?;
        columns.numbers("velocity", bodies().flat_map(|b| -> [f64; 3] { b.velocity.into() }))?;
        Ok(columns.done())
    }

    /// Bodies that move as they deform: name, material, and what they are in words.
    fn moving<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let moving = || self.scene.moving.iter();
        let columns = Columns::new(py);
        columns.texts("name", moving().map(|body| &body.name))?;
        columns.texts("material", moving().map(|body| &body.material.name))?;
        columns.texts("about", moving().map(SceneMovingBody::about))?;
        Ok(columns.done())
    }
}

/// The material presets with the source of each value, as JSON.
#[pyfunction]
pub(crate) fn materials_json() -> String {
    presets_json().to_string()
}

/// The JSON schema of scene files.
#[pyfunction]
pub(crate) fn schema_json() -> String {
    cullet::scene::schema().to_string()
}
