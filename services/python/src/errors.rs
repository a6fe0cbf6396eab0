//! Errors of the facade as exceptions of `cullet._errors`.

use cullet::{LinkError, RecordError, SceneErrors};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::fmt::Display;

/// An exception of the package, by its name.
fn raised(py: Python<'_>, class: &str, arguments: impl FnOnce() -> PyResult<Py<PyAny>>) -> PyErr {
    let made = || {
        let class = py.import("cullet._errors")?.getattr(class)?;
        class.call_method1("_of", (arguments()?,))
    };
    match made() {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

fn with_text(py: Python<'_>, class: &str, error: &impl Display) -> PyErr {
    raised(py, class, || Ok(error.to_string().into_pyobject(py)?.unbind().into_any()))
}

/// All that is wrong with a scene: the text, and a dictionary for each place.
pub(crate) fn of_scene(py: Python<'_>, errors: &SceneErrors) -> PyErr {
    raised(py, "SceneError", || {
        let places = PyList::empty(py);
        for error in &errors.errors {
            let place = PyDict::new(py);
            place.set_item("path", &error.path)?;
            place.set_item("message", &error.message)?;
            place.set_item("help", error.help.as_ref())?;
            let at = error.place();
            let at = at.as_ref();
            place.set_item("file", at.map(|at| &at.file))?;
            place.set_item("line", at.map(|at| at.line))?;
            place.set_item("column", at.map(|at| at.column))?;
            places.append(place)?;
        }
        Ok((errors.to_string(), places).into_pyobject(py)?.unbind().into_any())
    })
}

/// A run that has no result.
pub(crate) fn of_run(py: Python<'_>, error: &impl Display) -> PyErr {
    with_text(py, "RunError", error)
}

/// A recording that cannot be read, drawn or exported.
pub(crate) fn of_recording(py: Python<'_>, error: &impl Display) -> PyErr {
    with_text(py, "RecordingError", error)
}

/// The same, of a reader.
pub(crate) fn of_record(py: Python<'_>) -> impl Fn(RecordError) -> PyErr {
    move |error| of_recording(py, &error)
}

/// What a client could not do.
pub(crate) fn of_client(py: Python<'_>, error: &LinkError) -> PyErr {
    with_text(py, "ClientError", error)
}

/// A sweep that is none.
pub(crate) fn of_sweep(py: Python<'_>, error: &impl Display) -> PyErr {
    raised(py, "SceneError", || {
        let none = PyList::empty(py);
        Ok((error.to_string(), none).into_pyobject(py)?.unbind().into_any())
    })
}
