//! Runs on this machine.

use crate::errors::of_run;
use crate::own_process;
use crate::scene::PyScene;
use cullet::worker::memory;
use cullet::{LocalPool, LocalWorkers, News, Outcome, Position, RunAgain, RunOptions};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

/// Python is asked no more often than this whether to stop, and told no more often how far it is.
const PERIOD: Duration = Duration::from_millis(100);

/// Cores less the one that the world is stepped on, at least 1.
#[pyfunction]
pub(crate) fn spare_cores() -> usize {
    cullet::spare_cores()
}

/// Workers that are kept for several runs, which take turns.
#[pyclass(name = "LocalPool", module = "cullet._cullet", frozen)]
#[derive(Debug)]
pub(crate) struct PyLocalPool {
    pool: Mutex<Option<LocalPool>>,
    /// The thread that has the run at hand, and calls its listener.
    runner: Mutex<Option<ThreadId>>,
}

impl PyLocalPool {
    fn runner(&self) -> MutexGuard<'_, Option<ThreadId>> {
        self.runner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Refuses a listener, which would wait for its own run. Other threads wait for their turn.
    fn turn(&self, py: Python<'_>) -> PyResult<()> {
        // Before a lock, which a thread may have held that is not here any more.
        own_process::check()?;
        if *self.runner() == Some(std::thread::current().id()) {
            return Err(of_run(py, &"the pool is in a run, which has to end first"));
        }
        Ok(())
    }
}

#[pymethods]
impl PyLocalPool {
    /// Starts workers: processes of the program `cullet`, or without one threads of this process.
    #[new]
    fn new(
        py: Python<'_>,
        workers: usize,
        threads: usize,
        program: Option<PathBuf>,
    ) -> PyResult<Self> {
        own_process::check()?;
        let kind = match program {
            Some(program) => {
                let mut kind = LocalWorkers::processes(program, workers, threads);
                if let (LocalWorkers::Processes(spawn), Some(bytes)) =
                    (&mut kind, memory::share(workers))
                {
                    spawn.args.extend(["--memory".to_owned(), (bytes >> 20).max(16).to_string()]);
                }
                kind
            }
            None => LocalWorkers::Threads { workers, threads },
        };
        let pool = py.detach(|| LocalPool::start(&kind)).map_err(|error| of_run(py, &error))?;
        Ok(Self { pool: Mutex::new(Some(pool)), runner: Mutex::default() })
    }

    /// Runs a scene into a folder. `tell` is called with a dictionary now and then; where it or
    /// Ctrl-C raises, the recording is finished and the exception goes on. `again`: the earlier run
    /// that is taken up, the step at which it is resumed, and most bytes of results to be kept.
    fn run<'py>(
        &self,
        py: Python<'py>,
        scene: &PyScene,
        out: PathBuf,
        tell: Option<Py<PyAny>>,
        again: (Option<PathBuf>, Option<u64>, u64),
    ) -> PyResult<Bound<'py, PyDict>> {
        self.turn(py)?;
        let scene = &scene.scene;
        let mut listener = RunListener::new(tell);
        let outcome = py.detach(|| {
            let pool = self.pool.lock().unwrap_or_else(PoisonError::into_inner);
            let pool = pool.as_ref()?;
            // Set in the calls of the listener, which the run makes between two looks at it.
            let stop = AtomicBool::new(false);
            let (from, from_step, keep) = &again;
            let (from, from_step, keep) = (from.as_deref(), *from_step, *keep);
            let again = RunAgain { from, from_step, keep };
            let options = RunOptions { out: &out, stop: &stop, tap: None, again };
            *self.runner() = Some(std::thread::current().id());
            let outcome = pool.run(scene, &options, &mut |news| {
                if listener.hear(news) {
                    stop.store(true, Ordering::Relaxed);
                }
            });
            *self.runner() = None;
            Some(outcome)
        });
        let outcome = outcome.ok_or_else(|| PyValueError::new_err("the pool is closed"))?;
        if outcome.is_ok() {
            // The last step.
            listener.tell();
        }
        if let Some(raised) = listener.raised {
            return Err(raised);
        }
        let Outcome { summary, unmet, interrupted, recording } =
            outcome.map_err(|error| of_run(py, &error))?;
        let told = PyDict::new(py);
        told.set_item("summary", summary.to_json())?;
        told.set_item("unmet", unmet)?;
        told.set_item("interrupted", interrupted)?;
        told.set_item("recording", recording)?;
        told.set_item("log", listener.lines)?;
        Ok(told)
    }

    /// Ends the workers, once the run at hand is over.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.turn(py)?;
        py.detach(|| drop(self.pool.lock().unwrap_or_else(PoisonError::into_inner).take()));
        Ok(())
    }
}

impl Drop for PyLocalPool {
    fn drop(&mut self) {
        let pool = self.pool.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if !own_process::is_own() {
            // Its threads are in the process that this one was forked from, and end there.
            return std::mem::forget(pool);
        }
        // Workers on threads are waited for, which need not hold up Python.
        Python::try_attach(|py| py.detach(|| drop(pool)));
    }
}

/// Who hears of a run on behalf of Python.
struct RunListener {
    tell: Option<Py<PyAny>>,
    told: Option<Instant>,
    /// What was not told yet.
    held: Option<Position>,
    lines: Vec<String>,
    raised: Option<PyErr>,
}

impl RunListener {
    fn new(tell: Option<Py<PyAny>>) -> Self {
        Self { tell, told: None, held: None, lines: Vec::new(), raised: None }
    }

    /// Whether the run is to stop.
    fn hear(&mut self, news: &News) -> bool {
        match news {
            News::Line(line) | News::Results(line) => self.lines.push(line.clone()),
            News::At(position) => {
                self.held = Some(*position);
                if self.told.is_none_or(|told| told.elapsed() >= PERIOD) {
                    self.tell();
                }
            }
        }
        self.raised.is_some()
    }

    /// Tells what is held, unless something was raised.
    fn tell(&mut self) {
        let Some(position) = self.held.take().filter(|_| self.raised.is_none()) else { return };
        self.told = Some(Instant::now());
        let said = Python::attach(|py| {
            py.check_signals()?;
            let Some(tell) = &self.tell else { return Ok(()) };
            let at = PyDict::new(py);
            at.set_item("time", position.time)?;
            at.set_item("end", position.end)?;
            at.set_item("bodies", position.bodies)?;
            at.set_item("fractures", position.fractures)?;
            at.set_item("jobs", position.jobs)?;
            at.set_item("jobs_done", f64::from(position.permille) / 1000.0)?;
            tell.call1(py, (at,)).map(drop)
        });
        self.raised = said.err();
    }
}
