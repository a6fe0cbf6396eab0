//! What is frozen into treated glass, and what that pays for once a plate is cut through
//! \[shells §4\].
//!
//! The stress of a tempered plate is a parabola over its thickness, σ₀(z) = σ_m(1 − 12z²/t²) with
//! σ_m = σ_s/2 in the middle and −σ_s at the faces. Its force and its moment are zero, so that a
//! shell neither bends under it nor feels it: it raises the strength of the faces, and it is the
//! store that dicing draws on. Where the cracks of dicing go is sampled, not solved.

use cullet_model::{Material, Treatment};

/// Share of the stored energy that becomes crack faces, η. 0.11 to 0.18 give the 40 to 100 pieces
/// in 50 × 50 mm that plates of 4 mm with σ_s = 90 MPa break into  \[EN 12150-1; calibrated: T1\].
pub const WALL_SHARE: f64 = 0.135;

/// Speed of the fronts of dicing over that of Rayleigh waves: 1450 m/s in soda-lime glass.
pub const FRONT_SPEED: f64 = 0.475;

/// Stored energy over a plate's area, U = 0.2(1 − ν)σ_s²t/E \[J/m²\].
#[must_use]
pub fn stored_energy(material: &Material, surface_stress: f64, thickness: f64) -> f64 {
    let square = surface_stress * surface_stress;
    0.2 * (1.0 - material.poisson) * square * thickness / material.young
}

/// Whether a plate dices once it is cut through: it is toughened, and stores at least G_f.
#[must_use]
pub fn dices(material: &Material, treatment: Option<&Treatment>, thickness: f64) -> bool {
    let Some(Treatment::Toughened { surface_stress }) = treatment else { return false };
    stored_energy(material, *surface_stress, thickness) >= material.fracture_energy
}

/// Mean width of the pieces of a plate that dices, the square root of their mean area:
/// d = 2G_f E/(0.8η(1 − ν)σ_m²) \[m\]. It does not depend on the thickness.
#[must_use]
pub fn piece_width(material: &Material, surface_stress: f64) -> f64 {
    let core = 0.5 * surface_stress;
    2.0 * material.fracture_energy * material.young
        / (0.8 * WALL_SHARE * (1.0 - material.poisson) * core * core)
}

#[cfg(test)]
mod tests {
    use super::{dices, piece_width, stored_energy};
    use cullet_model::{Material, Treatment};

    const GLASS: Material = Material {
        density: 2480.0,
        young: 74e9,
        poisson: 0.23,
        failure_stress: 50e6,
        fracture_energy: 7.4,
    };

    /// 4 mm at 100 MPa stores some 85 J/m²; the core stress from which on it dices is 15 MPa.
    #[test]
    fn energy_and_threshold_are_those_of_the_sources() {
        assert!((stored_energy(&GLASS, 100e6, 4e-3) / 83.2 - 1.0).abs() < 0.01);
        let toughened = |surface_stress| Treatment::Toughened { surface_stress };
        assert!(!dices(&GLASS, Some(&toughened(29e6)), 4e-3));
        assert!(dices(&GLASS, Some(&toughened(31e6)), 4e-3));
        assert!(!dices(&GLASS, Some(&Treatment::HeatStrengthened { surface_stress: 90e6 }), 4e-3));
        assert!(!dices(&GLASS, None, 4e-3));
    }

    /// EN 12150-1: 40 pieces or more in 50 × 50 mm, and no dust.
    #[test]
    fn pieces_are_as_many_as_the_standard_counts() {
        let count = 2.5e-3 / piece_width(&GLASS, 90e6).powi(2);
        assert!((40.0..100.0).contains(&count), "{count}");
    }
}
