//! What is done to glass after it was drawn: stresses frozen into it, or a film between two panes.

/// A treatment of a plate of glass. Further ones will follow: a family refuses those that it does
/// not know.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Treatment {
    /// Faces under pressure, too little of it for the plate to dice: EN 1863-1.
    HeatStrengthened {
        /// Pressure at the faces, |σ_s| \[Pa\].
        surface_stress: f64,
    },
    /// Faces under so much pressure that the plate dices once it is cut through: EN 12150-1.
    Toughened {
        /// Pressure at the faces, |σ_s| \[Pa\].
        surface_stress: f64,
    },
    /// Plies that an interlayer holds together: EN ISO 12543.
    Laminated {
        /// What is between the plies.
        interlayer: Interlayer,
    },
}

/// The film of a laminated plate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Interlayer {
    /// Thickness of the film \[m\].
    pub thickness: f64,
    /// Tension at which it tears \[Pa\].
    pub strength: f64,
    /// Length at which it tears over its first length \[1\].
    pub stretch: f64,
}

impl Treatment {
    /// What a plate of it is called in messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::HeatStrengthened { .. } => "heat-strengthened glass",
            Self::Toughened { .. } => "toughened glass",
            Self::Laminated { .. } => "laminated glass",
        }
    }

    /// Pressure at the faces, |σ_s| \[Pa\]; zero where nothing is frozen in.
    #[must_use]
    pub fn surface_stress(&self) -> f64 {
        match self {
            Self::HeatStrengthened { surface_stress } | Self::Toughened { surface_stress } => {
                *surface_stress
            }
            Self::Laminated { .. } => 0.0,
        }
    }

    /// Its numbers: what each is, its value, the least and the greatest that holds.
    #[must_use]
    pub fn bounds(&self) -> Vec<(&'static str, f64, f64, f64)> {
        match self {
            Self::HeatStrengthened { surface_stress } | Self::Toughened { surface_stress } => {
                vec![("surface stress [Pa]", *surface_stress, 1e6, 1e9)]
            }
            Self::Laminated { interlayer } => vec![
                ("thickness of the interlayer [m]", interlayer.thickness, 1e-6, 0.1),
                ("strength of the interlayer [Pa]", interlayer.strength, 1e3, 1e9),
                ("stretch of the interlayer [1]", interlayer.stretch, 1.0, 20.0),
            ],
        }
    }
}

impl Interlayer {
    /// Energy that tears it, over its area: thickness times strength times (stretch − 1), of a film
    /// that flows at its strength \[J/m²\].
    #[must_use]
    pub fn tear_energy(&self) -> f64 {
        self.thickness * self.strength * (self.stretch - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Interlayer, Treatment};

    /// Polyvinyl butyral of 0.76 mm: 20 MPa over as long again.
    #[test]
    fn a_film_takes_its_strength_over_what_it_is_drawn_out() {
        let film = Interlayer { thickness: 0.76e-3, strength: 20e6, stretch: 2.0 };
        assert!((film.tear_energy() - 15_200.0).abs() < 1e-6);
    }

    #[test]
    fn every_number_has_a_bound_that_holds_for_usual_glass() {
        let interlayer = Interlayer { thickness: 0.76e-3, strength: 20e6, stretch: 2.0 };
        let all = [
            Treatment::HeatStrengthened { surface_stress: 40e6 },
            Treatment::Toughened { surface_stress: 90e6 },
            Treatment::Laminated { interlayer },
        ];
        for treatment in all {
            for (what, value, low, high) in treatment.bounds() {
                assert!((low..=high).contains(&value), "{what} of {}", treatment.kind());
            }
        }
    }
}
