//! Numbers as bytes, little-endian, for `numpy.frombuffer`.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// A number with its bytes.
pub(crate) trait LittleEndian {
    /// Appends them.
    fn put(self, bytes: &mut Vec<u8>);
}

macro_rules! little_endian {
    ($($number:ty),*) => {$(
        impl LittleEndian for $number {
            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        }
    )*};
}

little_endian!(u8, u32, u64, i64, f32, f64);

impl LittleEndian for bool {
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.push(self.into());
    }
}

/// The bytes of numbers, one after another.
pub(crate) fn packed<T: LittleEndian>(numbers: impl IntoIterator<Item = T>) -> Vec<u8> {
    let numbers = numbers.into_iter();
    let mut bytes = Vec::with_capacity(numbers.size_hint().0 * size_of::<T>());
    numbers.for_each(|number| number.put(&mut bytes));
    bytes
}

/// Columns by name.
pub(crate) struct Columns<'py> {
    py: Python<'py>,
    all: Bound<'py, PyDict>,
}

impl<'py> Columns<'py> {
    pub(crate) fn new(py: Python<'py>) -> Self {
        Self { py, all: PyDict::new(py) }
    }

    /// A column of numbers.
    pub(crate) fn numbers<T: LittleEndian>(
        &self,
        name: &str,
        numbers: impl IntoIterator<Item = T>,
    ) -> PyResult<()> {
        self.all.set_item(name, PyBytes::new(self.py, &packed(numbers)))
    }

    /// A column of texts.
    pub(crate) fn texts<T: AsRef<str>>(
        &self,
        name: &str,
        texts: impl IntoIterator<Item = T>,
    ) -> PyResult<()> {
        let texts: Vec<T> = texts.into_iter().collect();
        let texts: Vec<&str> = texts.iter().map(AsRef::as_ref).collect();
        self.all.set_item(name, texts)
    }

    pub(crate) fn done(self) -> Bound<'py, PyDict> {
        self.all
    }
}
