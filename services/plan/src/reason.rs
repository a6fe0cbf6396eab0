//! Why a hit is not solved, with the bound.

/// Why a hit is not solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidReason {
    /// Gate 1: the energy of the hit opens less crack than any way through the body needs.
    Energy {
        /// η \[1\].
        efficiency: f64,
        /// A_max = η E_n / G_f \[m²\].
        affordable: f64,
        /// Smallest section \[m²\].
        section: f64,
    },
    /// Gate 2: no estimate of the stress comes near the strength.
    Stress {
        /// Greatest estimate \[Pa\].
        stress: f64,
        /// σ_f \[Pa\].
        strength: f64,
        /// Share of σ_f below which nothing cracks \[1\].
        safety: f64,
    },
    /// The body has too many fractures behind it for a solver.
    Generation {
        /// Its generation.
        generation: u32,
        /// Up to and including this one a solver is asked.
        limit: u32,
    },
    /// The body is too small a part of the original for a solver.
    Size {
        /// Volume over the original body's \[1\].
        ratio: f64,
        /// Least share that is solved \[1\].
        limit: f64,
    },
    /// The body has too few cells for a solver at the spacing that the scene asks for.
    Cells {
        /// How many it has \[1\].
        cells: f64,
        /// Fewest that are solved \[1\].
        limit: f64,
        /// The spacing \[m\].
        spacing: f64,
    },
    /// Too few cells lie across the body's thickness at the spacing that the scene allows (F14).
    Thin {
        /// How many do \[1\].
        cells: f64,
        /// Fewest that bending needs \[1\].
        limit: f64,
        /// The spacing \[m\].
        spacing: f64,
        /// Material points of a solve with that many \[1\].
        points: f64,
    },
    /// Gate 0: what breaks off the body is too small to be seen.
    Unseen {
        /// Half of its smallest section across \[m\].
        size: f64,
        /// Two pixels \[m\].
        limit: f64,
    },
    /// The body is of a metal that yields, and no estimate of the stress comes near that.
    Yield {
        /// Greatest estimate \[Pa\].
        stress: f64,
        /// That at which it yields \[Pa\].
        yield_stress: f64,
        /// Share of it below which nothing flows \[1\].
        safety: f64,
    },
    /// The body is of a metal that yields: the dent is too shallow to be seen, and nothing bends.
    Dent {
        /// Its depth \[m\].
        depth: f64,
        /// Least depth that is solved \[m\].
        limit: f64,
    },
}

impl std::fmt::Display for RigidReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::Energy { efficiency, affordable, section } => {
                if efficiency < 1.0 {
                    write!(f, "{efficiency:.2} of ")?;
                }
                write!(
                    f,
                    "the energy opens at most {affordable:.3e} m² of crack; \
                     the smallest section is {section:.3e} m²"
                )
            }
            Self::Stress { stress, strength, safety } => write!(
                f,
                "the stress reaches {stress:.3e} Pa, \
                 below {safety} of the strength {strength:.3e} Pa"
            ),
            Self::Generation { generation, limit } => {
                write!(f, "generation {generation} is beyond {limit}, the last that is solved")
            }
            Self::Size { ratio, limit } => {
                write!(f, "the body is {ratio:.3e} of the original, below {limit:.3e}")
            }
            Self::Cells { cells, limit, spacing } => {
                write!(f, "the body has {cells:.1} cells of {spacing:.3e} m, below {limit}")
            }
            Self::Thin { cells, limit, spacing, points } => write!(
                f,
                "{cells:.2} cells of {spacing:.3e} m lie across the thickness, below {limit}; \
                 that takes {points:.0} points"
            ),
            Self::Yield { stress, yield_stress, safety } => write!(
                f,
                "the stress reaches {stress:.3e} Pa, \
                 below {safety} of that at which the metal yields, {yield_stress:.3e} Pa"
            ),
            Self::Dent { depth, limit } => write!(
                f,
                "it makes a dent of about {depth:.3e} m, below {limit:.3e} m, and bends nothing"
            ),
            Self::Unseen { size, limit } => {
                write!(f, "its halves are {size:.3e} m across, below two pixels, {limit:.3e} m")
            }
        }
    }
}
