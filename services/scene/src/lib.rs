//! The scene loader: a TOML file to bodies that are ready for the world, or every error at once.
//!
//! [`mod@format`] is the one source of the reader, of the schema and of the [`reference()`].
//! `cullet_document` reads the text; `resolve` makes bodies of it. `position` places the *origin*
//! of a shape or mesh file (or the point that `anchor` names); a loaded body's own origin is its
//! centroid, and its pose makes up for it.

mod admission;
mod animation;
pub mod body;
mod body_names;
mod bonds;
pub mod context;
mod directed;
pub mod direction;
pub mod directions;
mod expect;
mod fields;
pub mod format;
mod generate;
pub mod geometry;
mod hits;
mod limits;
mod load;
pub mod material;
mod materials_json;
mod motions;
mod moving;
mod names;
mod overlap;
pub mod parts;
pub mod pieces;
mod places;
mod preflight;
mod reference;
pub mod resolve;
pub mod rigid;
mod scene;
pub mod schema;
mod score_line;
pub mod shape;
pub mod sheet;
mod sourced;
pub mod strength;
pub mod surface_detail;
mod taken;
#[cfg(test)]
mod tests;
mod treatment;

pub use directions::SceneHit;
pub use expect::Observed;
pub use format::{Expect, SolverChoice, View};
pub use load::{SCENE_FILE, load, load_bundle, load_bundle_until, name_at};
pub use material::{
    Kind, Preset, SceneMaterial, Sourced, is_preset, preset, presets, presets_json, presets_text,
};
pub use moving::SceneMovingBody;
pub use reference::reference;
pub use scene::{Scene, SceneBody};
pub use schema::schema;
pub use treatment::PresetTreatment;
