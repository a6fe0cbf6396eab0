//! TOML documents for people: values with units, includes, overrides on the command line, a schema
//! that editors read, and all errors at once, each with its file, line and column.
//!
//! ```text
//! text ─▶ tree, each value with its place ─▶ includes ─▶ overrides ─▶ schema, units ─▶ the type
//! ```
//!
//! Reading files is in [`files`]; everything else is a function of text and bytes.

pub mod check;
pub mod document;
pub mod error;
pub mod files;
pub mod origin;
pub mod overrides;
pub mod schema;
pub mod sheet;
pub mod tree;
pub mod unit;

pub use error::{SceneError, SceneErrorKind, SceneErrors, SourcePlace};
pub use files::{Bundle, FileError, SceneFile};
pub use schema::printed;
