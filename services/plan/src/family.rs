//! The families of solvers that a scene may name, and what takes over from each.

/// What is known of a family before any worker is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FamilyPlan {
    /// Its name on the wire and in scenes.
    pub name: &'static str,
    /// One sentence for the reference of scenes.
    pub about: &'static str,
    /// The family that takes what this one declines; of what yields, it is [`DUCTILE`].
    pub fallback: Option<&'static str>,
    /// Whether there is a model of its cost and error, so that its spacing can be planned.
    pub planned: bool,
}

/// The family that is asked where a scene leaves it open.
pub const DEFAULT: &str = "brittle";
/// The family for bodies that do not deserve a solve: its fragments are sampled.
pub const SAMPLED: &str = "geometric";

/// The family for thin plates that are hit on their face.
pub const SHELL: &str = "shell";

/// The family for metal that yields and is no thin wall.
pub const DUCTILE: &str = "ductile";

/// The family of points and bonds, for whom a scene names it.
pub const PERIDYNAMICS: &str = "peridynamics";

/// Every family.
pub const FAMILIES: &[FamilyPlan] = &[
    FamilyPlan {
        name: DEFAULT,
        about: "Stress and damage on material points, for brittle solids; `geometric` takes over \
                where it declines.",
        fallback: Some(SAMPLED),
        planned: true,
    },
    FamilyPlan {
        name: DUCTILE,
        about: "Plastic flow on material points, for solid metal that yields: what comes of a hit \
                is a dent, and the body stays one.",
        fallback: None,
        planned: false,
    },
    FamilyPlan {
        name: PERIDYNAMICS,
        about: "Points and bonds, for solids that yield a little, break, or both: dents and parts. \
                Only where a scene names it; `ductile` takes over where it declines what yields, \
                `geometric` what does not.",
        fallback: Some(SAMPLED),
        planned: false,
    },
    FamilyPlan {
        name: SHELL,
        about: "Bending and cracks of thin plates and curved walls, on their midsurface; \
                where it declines, `ductile` takes over what yields, `geometric` what does not.",
        fallback: Some(SAMPLED),
        planned: false,
    },
    FamilyPlan {
        name: SAMPLED,
        about: "Voronoi cells around the point of the hit, their number from its energy: fast.",
        fallback: None,
        planned: false,
    },
];

/// The family of that name.
#[must_use]
pub fn by_name(name: &str) -> Option<&'static FamilyPlan> {
    FAMILIES.iter().find(|family| family.name == name)
}
