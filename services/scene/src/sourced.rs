//! Values with their sources, and what may be wrong with them.

/// How a value was come by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Measured, and read in the source that is named.
    Measured,
    /// The usual size of it; no measurement was read.
    Typical,
}

/// A value, how it was come by, and where it stands.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sourced {
    /// In SI.
    pub value: f64,
    /// Measured or typical.
    pub kind: Kind,
    /// Where it stands, or what it was computed from.
    pub source: &'static str,
}

/// A key and what is wrong with it.
pub(super) type Fault = (&'static str, String);
