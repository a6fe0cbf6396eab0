//! How a body comes apart where the scene says so, as it is written.

use super::dynamic::BodyPart;
use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// How a body comes apart where the scene says so: art direction of what the solve found. It does
/// not decide whether the body breaks, and costs no energy; what it divides or joins is recorded as
/// *directed*. It holds for the first fracture of the body: its fragments break as they are hit.
/// Places are in the body's own frame, whose origin is that of the shape or of the mesh file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WantedPieces {
    /// Fragments that the body breaks into, debris aside \[1\]: within a fifth of it. Too few are
    /// divided, more finely near the hits; of too many the smallest are joined to neighbours. At
    /// least the number of `guides`, and at most `fracture.max_fragments`. Pieces that cannot be
    /// joined exactly stay apart, with a warning.
    #[schemars(range(min = 2, max = 4096), extend("x-default" = "as many as the solve finds"))]
    pub count: Option<u32>,
    /// Points that each get a fragment of their own \[m\], in the body or outside it by at most 1 %
    /// of its diagonal.
    #[schemars(schema_with = "unit::places3", extend("x-default" = "none"))]
    pub guides: Vec<[f64; 3]>,
    /// Parts of the body that each stay in one fragment: at most 64, each with at most one of the
    /// `guides`. Their strength is 100 times the material's, on later hits too, and fragments that
    /// reach into a part all the same are joined.
    #[schemars(length(max = 64), extend("x-default" = "none"))]
    pub whole: Vec<BodyPart>,
}
