//! A client of a farm. Answers are the JSON of docs/protocol.md.

use crate::errors::{of_client, of_sweep};
use crate::own_process;
use crate::scene::PyScene;
use cullet::coordinator::sweep::Sweep;
use cullet::proto::security;
use cullet::{Client, LinkError, RunInfo, Terms};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, TryFromFloatSecsError};

/// While a full queue is asked for room, Python is asked so often whether to stop.
const SLICE: Duration = Duration::from_secs(1);

/// A client that is connected.
#[pyclass(name = "Client", module = "cullet._cullet", frozen)]
pub(crate) struct PyClient {
    client: Arc<Client>,
    /// Longest wait for an answer.
    patience: Duration,
}

impl PyClient {
    fn asked<T: Send>(
        &self,
        py: Python<'_>,
        ask: impl FnOnce(&Client) -> Result<T, LinkError> + Send,
    ) -> PyResult<T> {
        own_process::check()?;
        py.detach(|| ask(&self.client)).map_err(|error| of_client(py, &error))
    }

    /// The same for an answer that is handed on as JSON.
    fn told<T: Send + Into<serde_json::Value>>(
        &self,
        py: Python<'_>,
        ask: impl FnOnce(&Client) -> Result<T, LinkError> + Send,
    ) -> PyResult<String> {
        Ok(self.asked(py, ask)?.into().to_string())
    }
}

impl Drop for PyClient {
    fn drop(&mut self) {
        if !own_process::is_own() {
            // Its link is in the process that this one was forked from, and ends there.
            std::mem::forget(Arc::clone(&self.client));
        }
    }
}

/// An answer as JSON.
fn json<T: serde::Serialize>(answer: &T) -> Result<serde_json::Value, LinkError> {
    serde_json::to_value(answer).map_err(|error| LinkError::Garbled(error.to_string()))
}

#[pymethods]
impl PyClient {
    /// Connects; `tls` is a folder with `ca.pem`, `cert.pem` and `key.pem`.
    #[new]
    fn new(
        py: Python<'_>,
        endpoint: &str,
        tls: Option<PathBuf>,
        user: &str,
        coordinator: &str,
        patience: f64,
    ) -> PyResult<Self> {
        own_process::check()?;
        let rules = tls.as_deref().map(security::identity).unwrap_or_default();
        let patience = Duration::try_from_secs_f64(patience)
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        let connected =
            py.detach(|| Client::connect_as(endpoint, &rules, patience)?.with(coordinator, user));
        let client = Arc::new(connected.map_err(|error| of_client(py, &error))?);
        Ok(Self { client, patience })
    }

    /// Hands a scene in; hands back the number of its run. A full queue is asked for room for
    /// `room` seconds, endless if infinite; without it for as long as one is patient.
    fn submit(
        &self,
        py: Python<'_>,
        scene: &PyScene,
        priority: i32,
        sweep: &str,
        ticket: Option<String>,
        room: Option<f64>,
    ) -> PyResult<u64> {
        own_process::check()?;
        let bundle = scene.bundle();
        let ticket = ticket.unwrap_or_else(|| Terms::unique().ticket);
        let wrong = |error: TryFromFloatSecsError| PyValueError::new_err(error.to_string());
        let room = match room {
            None => self.patience,
            Some(f64::INFINITY) => Duration::MAX,
            Some(room) => Duration::try_from_secs_f64(room).map_err(wrong)?,
        };
        let mut terms = Terms { ticket, priority, sweep: sweep.to_owned(), room: None };
        let since = Instant::now();
        loop {
            let left = room.saturating_sub(since.elapsed());
            terms.room = Some(left.min(SLICE));
            match py.detach(|| self.client.submit(&bundle, &terms)) {
                Err(LinkError::Busy { .. }) if left > SLICE => py.check_signals()?,
                Err(LinkError::Busy { endpoint, .. }) => {
                    let seconds = room.as_secs_f64();
                    return Err(of_client(py, &LinkError::Busy { endpoint, seconds }));
                }
                handed => return handed.map_err(|error| of_client(py, &error)),
            }
        }
    }

    /// News of a run from a line on, as JSON; waits a second for them.
    fn news(&self, py: Python<'_>, run: u64, from: u64) -> PyResult<String> {
        self.told(py, |client| json(&client.news(run, from)?))
    }

    /// What is known of a run, as JSON.
    fn run(&self, py: Python<'_>, run: u64) -> PyResult<String> {
        self.told(py, |client| json(&client.run(run)?))
    }

    /// Every run there, as JSON.
    fn runs(&self, py: Python<'_>) -> PyResult<String> {
        self.told(py, |client| json(&client.runs()?))
    }

    /// What the coordinator is and has, as JSON.
    fn about(&self, py: Python<'_>) -> PyResult<String> {
        self.told(py, |client| json(&client.about()?))
    }

    /// Fetches the files of a run that is over into a folder that has no other run; hands back
    /// where they are.
    fn fetch(&self, py: Python<'_>, run: u64, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
        self.asked(py, |client| fetched(client, run, &folder))
    }

    fn cancel(&self, py: Python<'_>, run: u64) -> PyResult<()> {
        self.asked(py, |client| client.cancel(run).map(drop))
    }

    fn pause(&self, py: Python<'_>, run: u64) -> PyResult<()> {
        self.asked(py, |client| client.pause(run).map(drop))
    }

    fn resume(&self, py: Python<'_>, run: u64) -> PyResult<()> {
        self.asked(py, |client| client.resume(run).map(drop))
    }

    fn retry(&self, py: Python<'_>, run: u64) -> PyResult<()> {
        self.asked(py, |client| client.retry(run).map(drop))
    }

    fn delete(&self, py: Python<'_>, run: u64) -> PyResult<()> {
        self.asked(py, |client| client.delete(run).map(drop))
    }

    /// Says that nothing more of a run is wanted.
    fn enough(&self, py: Python<'_>, run: u64) {
        if own_process::is_own() {
            py.detach(|| self.client.enough(run));
        }
    }

    #[getter]
    fn user(&self) -> &str {
        self.client.user()
    }
}

fn fetched(client: &Client, run: u64, folder: &Path) -> Result<Vec<PathBuf>, LinkError> {
    let info: RunInfo = client.run(run)?;
    if !info.state.is_over() {
        return Err(LinkError::Later(format!("run {run} is {}, not over", info.state.word())));
    }
    if !cullet::is_free_to_fetch(folder) {
        let why = "there is a run in this folder";
        return Err(LinkError::Occupied { folder: folder.to_owned(), why });
    }
    let files = client.fetch(&info, folder);
    client.enough(run);
    files
}

/// Whether a folder holds a run or a sweep.
#[pyfunction]
pub(crate) fn is_taken(folder: PathBuf) -> bool {
    cullet::is_taken(&folder)
}

/// A sweep file worked out: the scene that it names, and for each run what is set, its values and
/// a label.
#[pyfunction]
pub(crate) fn sweep_rows<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    let sweep = Sweep::read(text).map_err(|error| of_sweep(py, &error))?;
    let told = PyDict::new(py);
    told.set_item("scene", &sweep.scene)?;
    told.set_item("keys", &sweep.keys)?;
    told.set_item("values", &sweep.rows)?;
    let set: Vec<Vec<String>> = sweep.rows.iter().map(|row| sweep.overrides(row)).collect();
    told.set_item("set", set)?;
    let labels: Vec<String> = sweep.rows.iter().map(|row| sweep.label(row)).collect();
    told.set_item("labels", labels)?;
    Ok(told)
}
