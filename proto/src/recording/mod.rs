//! What a recording says in messages of our own: protobuf, each with its schema embedded, so that
//! any MCAP reader decodes them without this code.

mod appearance;
mod messages;
mod schema;
mod solid;
mod text;

pub use appearance::{Appearance, AppearanceError, AppearanceMaterial, AppearanceTexture};
pub use messages::*;
pub use schema::{PACKAGE, Recorded};
pub use solid::{GeometryError, geometry_hash};
pub use text::schema_text;
