//! The specimen loader: a TOML file to a job that any process can solve, or every error at once.
//!
//! Units, overrides, materials and errors are those of scenes; `format` is the one source of the
//! schema and of the reader; `metric` makes numbers of what comes back.

mod asked;
mod builder;
pub mod format;
mod load;
mod materials;
mod metric;
mod paths;
mod resolve;
mod schema;
mod subject;
#[cfg(test)]
mod tests;
mod watch;
pub mod whole;

pub use format::{Ends, Expected, Metric, Reduction};
pub use load::load;
pub use metric::{MetricCheck, MetricVerdict, reduce, speeds, weigh};
pub use schema::schema;
pub use subject::{Specimen, Subject};
