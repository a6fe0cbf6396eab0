//! What the gates know of a body.

/// What the gates know of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GateBody {
    /// Volume \[m³\].
    pub volume: f64,
    /// Greatest extent L \[m\].
    pub length: f64,
    /// Typical wall thickness t = 2V/A \[m\], at most the least extent.
    pub thickness: f64,
    /// Thickness for bending as a solver sees it \[m\]: `thickness` of
    /// `cullet_geometry::inside::Nearest`.
    pub depth: f64,
    /// Smallest section of several through the body \[m²\].
    pub section: f64,
    /// Volume over the original body's \[1\].
    pub volume_ratio: f64,
    /// How many fractures it has behind it.
    pub generation: u32,
    /// Least strength anywhere in it over its material's \[1\].
    pub weakest: f64,
}
