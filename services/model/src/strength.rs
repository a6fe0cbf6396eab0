//! Strength from place to place: flaws, layers, weak planes, and what a scene paints.
//!
//! Flaws are a Gaussian random field g of unit variance and correlation ℓ, a sum of random Fourier
//! modes (so that no axis is favoured), mapped through Weibull's quantile:
//! f = (−ln(1 − Φ(g)))^(1/m) / Γ(1 + 1/m), of mean 1. g is held within ±`TAIL`, which moves the
//! mean by less than 1e-3. σ_f is thus the *mean local* strength; a body of n correlation volumes
//! under even tension begins to break at about n^(−1/m) of it.

mod paint;

pub use paint::{GROOVE, Region, Stroke, VertexPaint, weakest_painted};

use cullet_geometry::Vec3;
use cullet_geometry::math::{scramble, unit};
use paint::{Brush, painted};
use std::sync::Arc;

/// Least correlation length in spacings: shorter flaws are noise to a band four spacings wide
/// (F23).
pub const CORRELATION: f64 = 4.0;

/// Modulus of a material of which nothing is said \[1\].
pub const WEIBULL: f64 = 10.0;

/// Modulus from which on strength is as good as even \[1\]: what travels has no infinity.
pub const EVEN: f64 = 1e3;

/// Greatest deviation of the Gaussian field, in standard deviations: one flaw in 741 is cut off.
pub const TAIL: f64 = 3.0;

/// Bounds of all factors together \[1\].
pub const BOUNDS: (f64, f64) = (0.01, 100.0);

/// Fourier modes: the kurtosis of their sum is within 0.03 of a Gaussian's.
const MODES: u64 = 64;

/// Streams of the seed's numbers.
const FLAWS: u64 = 0x57e4;
const JITTER: u64 = 0x1a7e;

/// Alternating layers: that of `0 ≤ normal·x < thickness` has σ_f, the next `ratio` of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct StrengthLayers {
    /// Unit normal.
    pub normal: Vec3,
    /// Thickness of one layer \[m\].
    pub thickness: f64,
    /// Strength of every second layer over σ_f \[1\].
    pub ratio: f64,
    /// Each boundary is moved by up to half this share of the thickness \[1\], below 1.
    pub jitter: f64,
}

/// Planes of one normal across which the strength is a share of σ_f.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct PatternWeakPlane {
    /// Unit normal, pattern frame.
    pub normal: Vec3,
    /// The share \[1\].
    pub ratio: f64,
}

/// What is known of a body's strength beside σ_f. Fragments keep all of it but `offset`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct StrengthField {
    /// Of the original body, so that fragments keep its flaws.
    pub seed: u64,
    /// Weibull modulus m of the flaws \[1\]; infinite means none.
    pub weibull: f64,
    /// Distance over which the correlation of flaws falls to 1/e \[m\]; at least
    /// [`CORRELATION`] spacings, and that without it.
    pub correlation: Option<f64>,
    /// From a point of the body's frame to where it was in the pattern frame, that of the original
    /// body as it was drawn \[m\]: fragments are moved from their parent's frame, never turned.
    pub offset: Vec3,
    /// A weak plane.
    pub weak_plane: Option<PatternWeakPlane>,
    /// Layers.
    pub layers: Option<StrengthLayers>,
    /// Painted regions; their factors multiply, but a line of grooves counts once.
    pub strokes: Vec<Stroke>,
    /// Factors painted on the surface; on the wire they travel behind the rest.
    #[cfg_attr(feature = "wire", serde(skip))]
    pub vertices: Option<Arc<VertexPaint>>,
}

impl Default for StrengthField {
    fn default() -> Self {
        Self {
            seed: 0,
            weibull: WEIBULL,
            correlation: None,
            offset: Vec3::zeros(),
            weak_plane: None,
            layers: None,
            strokes: Vec::new(),
            vertices: None,
        }
    }
}

impl StrengthField {
    /// No flaws that matter, nothing painted.
    #[must_use]
    pub fn even() -> Self {
        Self { weibull: EVEN, ..Self::default() }
    }

    /// The grooves of its lines that weaken it, as a grid of `spacing` \[m\] has them, in the
    /// body's frame.
    #[must_use]
    pub fn scored(&self, spacing: f64) -> Vec<Region> {
        let weak = self.strokes.iter().filter(|stroke| stroke.factor < 1.0);
        let groove = |stroke: &Stroke| match stroke.resolved(spacing).region {
            Region::Groove { from, to, inward, half_width } => {
                let [from, to] = [from, to].map(|end| end - self.offset);
                Some(Region::Groove { from, to, inward, half_width })
            }
            _ => None,
        };
        weak.filter_map(groove).collect()
    }
}

/// A strength field made ready for one spacing.
#[derive(Clone, Debug)]
pub struct Strength {
    field: StrengthField,
    /// Wave vectors \[1/m\] and phases \[rad\].
    modes: Vec<(Vec3, f64)>,
    mean: f64,
    brush: Option<Brush>,
    /// The strokes of scored lines.
    grooves: Vec<Stroke>,
    /// As in the field.
    pub weak_plane: Option<PatternWeakPlane>,
}

impl Strength {
    /// Readies a field for a grid of `spacing` \[m\] (the largest, where it differs by axis).
    #[must_use]
    pub fn new(field: &StrengthField, spacing: f64) -> Self {
        let length = field.correlation.unwrap_or(0.0).max(CORRELATION * spacing);
        let inverse = 1.0 / field.weibull;
        let some = inverse > 0.0;
        let strokes: Vec<Stroke> = field.strokes.iter().map(|own| own.resolved(spacing)).collect();
        let is_groove = |own: &&Stroke| matches!(own.region, Region::Groove { .. });
        Self {
            grooves: strokes.iter().filter(is_groove).copied().collect(),
            modes: (0..MODES).filter(|_| some).map(|k| mode(field.seed, k, length)).collect(),
            mean: libm::tgamma(1.0 + inverse),
            brush: field.vertices.as_ref().map(Brush::new),
            weak_plane: field.weak_plane,
            field: StrengthField { strokes, ..field.clone() },
        }
    }

    /// Local strength over σ_f at `x`, a point of the body's frame \[m\]; within [`BOUNDS`].
    #[must_use]
    pub fn factor(&self, x: &Vec3) -> f64 {
        let x = x + self.field.offset;
        let painted = painted(&self.field.strokes, &x);
        let vertices = self.brush.as_ref().map_or(1.0, |brush| brush.factor(&x));
        let layers = self.field.layers.map_or(1.0, |layers| layers.factor(&x, self.field.seed));
        (self.flaws(&x) * layers * painted * vertices).clamp(BOUNDS.0, BOUNDS.1)
    }

    /// Toughness (K_Ic) below scored lines over that without them at `x`, a point of the body's
    /// frame \[m\], as little as its strength is of σ_f: for families in which strength alone does
    /// not say what a crack costs. 1 where the scene paints the place stronger \[1\].
    #[must_use]
    pub fn score(&self, x: &Vec3) -> f64 {
        let x = x + self.field.offset;
        let score = painted(&self.grooves, &x);
        // Painted stronger as a whole, as what is to stay in one piece, it is no groove.
        let painted = painted(&self.field.strokes, &x);
        score.max(painted).clamp(BOUNDS.0, 1.0)
    }

    fn flaws(&self, x: &Vec3) -> f64 {
        if self.modes.is_empty() {
            return 1.0;
        }
        let sum: f64 = self.modes.iter().map(|(k, phase)| libm::cos(k.dot(x) + phase)).sum();
        let g = (sum * (2.0 / MODES as f64).sqrt()).clamp(-TAIL, TAIL);
        let above = 0.5 * libm::erfc(g * std::f64::consts::FRAC_1_SQRT_2);
        libm::pow(-libm::log(above), 1.0 / self.field.weibull) / self.mean
    }
}

/// A wave of the spectrum of the correlation exp(−(r/ℓ)²): each component of k is normal with the
/// deviation √2/ℓ.
fn mode(seed: u64, index: u64, length: f64) -> (Vec3, f64) {
    let turn = 2.0 * std::f64::consts::PI;
    let draw = |n: u64| unit(seed, FLAWS, 8 * index + n);
    let normal = |n: u64| {
        let radius = (-2.0 * libm::log(1.0 - draw(2 * n))).sqrt();
        radius * libm::cos(turn * draw(2 * n + 1))
    };
    let k = Vec3::new(normal(0), normal(1), normal(2));
    (k * (std::f64::consts::SQRT_2 / length), turn * draw(6))
}

impl StrengthLayers {
    fn factor(&self, x: &Vec3, seed: u64) -> f64 {
        let height = self.normal.dot(x) / self.thickness;
        let below = height.floor();
        let boundary = |k: f64| {
            let draw = unit(seed, JITTER, scramble(k as i64 as u64));
            k + self.jitter * (draw - 0.5)
        };
        let layer = if height < boundary(below) {
            below - 1.0
        } else if height >= boundary(below + 1.0) {
            below + 1.0
        } else {
            below
        };
        if layer.rem_euclid(2.0) == 0.0 { 1.0 } else { self.ratio }
    }
}

#[cfg(test)]
mod tests;
