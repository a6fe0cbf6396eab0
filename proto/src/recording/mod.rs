//! What a recording says in messages of our own: protobuf, each with its schema embedded, so that
//! any MCAP reader decodes them without this code.

mod appearance;
mod joints;
mod messages;
mod schema;
mod sheet_error;
mod sheets;
mod solid;
mod text;
mod vector;
mod windows;

pub use appearance::{Appearance, AppearanceError, AppearanceMaterial, AppearanceTexture};
pub use joints::{BodyJoint, JointType};
pub use messages::*;
pub use schema::{PACKAGE, Recorded};
pub use sheet_error::SheetError;
pub use sheets::{
    SheetFrame, SheetSurface, check_surface, schema_of, sheet_schema_bytes, surface_hash,
};
pub use solid::{GeometryError, geometry_hash};
pub use text::schema_text;
pub use vector::Vector3;
pub use windows::{SheetLedger, SheetPiece, SheetWindow};
