//! What comes of a solve.

use crate::BodyShape;
use cullet_geometry::{Sheet, Solid, Surface, Vec3};

/// One part of a broken body, in the body's frame before it broke.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragment {
    /// Its closed boundary \[m\].
    pub solid: Solid,
    /// Convex parts that stand in for it in collisions: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// Velocity of its centroid that the hit gave it, beside the body's motion before the hit
    /// \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity that the hit gave it, likewise \[rad/s\].
    pub spin: Vec3,
    /// Cracks that end inside it; empty where there are none, or the method knows none.
    pub sheet: Sheet,
}

/// What a solve cost and what it found out about itself.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// `Solver::NAME`.
    pub solver: String,
    /// Why the family that was asked first did not run, if it refused.
    pub refusal: Option<String>,
    /// Grid spacing h \[m\]; zero where a method has none.
    pub spacing: f64,
    /// Material points; zero where a method has none.
    pub particles: u64,
    /// Time steps taken.
    pub steps: u64,
    /// Simulated time \[s\].
    pub simulated: f64,
    /// Area of the crack between fragments \[m²\] (counted once, not per side).
    pub crack_area: f64,
    /// G_f times `crack_area` \[J\].
    pub fracture_energy: f64,
    /// Energy the damage law dissipated \[J\].
    pub dissipated_energy: f64,
    /// What only the family knows, by name.
    pub details: Vec<Figure>,
    /// What the detectors noticed and let pass, a sentence each.
    pub warnings: Vec<String>,
}

/// A number that a family reports beside what all of them do.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Figure {
    /// What it is, in lower case with underscores.
    pub name: String,
    /// Its SI unit; 1 where it has none.
    pub unit: String,
    /// The value itself.
    pub value: f64,
}

/// [`Figure`] of the stress at which cracks grow over σ_f \[1\]; below 1 the solve was
/// toughness-controlled (F01).
pub const STRENGTH_RATIO: &str = "strength_ratio";
/// [`Figure`] of the share of points with damage above one half \[1\].
pub const DAMAGED_FRACTION: &str = "damaged_fraction";
/// [`Figure`] of the impulse that the solve put into the body \[N·s\].
pub const DELIVERED_IMPULSE: &str = "delivered_impulse";
/// [`Figure`] of the fragments before the scene's direction \[1\].
pub const FOUND_FRAGMENTS: &str = "found_fragments";
/// [`Figure`] of the largest fragment's share of their volume before the scene's direction \[1\].
pub const FOUND_LARGEST: &str = "found_largest";
/// [`Figure`] of the crack area that direction added \[m²\], which cost no energy.
pub const ADDED_CRACK_AREA: &str = "directed_crack_area";
/// [`Figure`] of the crack area that direction closed again \[m²\]; its energy stays spent.
pub const CLOSED_CRACK_AREA: &str = "closed_crack_area";

impl Report {
    /// Adds a figure of the family's own.
    #[must_use]
    pub fn with(mut self, name: &str, unit: &str, value: f64) -> Self {
        self.details.push(Figure { name: name.to_owned(), unit: unit.to_owned(), value });
        self
    }

    /// The family's own figure of that name.
    #[must_use]
    pub fn detail(&self, name: &str) -> Option<f64> {
        self.details.iter().find(|figure| figure.name == name).map(|figure| figure.value)
    }
}

/// A grain of debris, in the body's frame before it broke: a point with a mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Where \[m\].
    pub position: Vec3,
    /// Velocity that the hit gave it, beside the body's motion before the hit \[m/s\].
    pub velocity: Vec3,
    /// Volume \[m³\].
    pub volume: f64,
    /// Diameter of the ball of that volume \[m\].
    pub size: f64,
}

/// Where a fragment comes from. The numbers are those of the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum FragmentOrigin {
    /// A solver found it.
    #[default]
    Solved = 0,
    /// It was sampled from a law.
    Sampled = 1,
    /// The scene asked for it: [`crate::ArtDirection`].
    Directed = 2,
}

impl FragmentOrigin {
    /// The word for it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Sampled => "sampled",
            Self::Directed => "directed",
        }
    }

    /// Sampled, or else solved.
    #[must_use]
    pub fn of_sampled(sampled: bool) -> Self {
        if sampled { Self::Sampled } else { Self::Solved }
    }
}

/// A body taken apart. One fragment means that nothing separated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fragmentation {
    /// Closed parts whose volumes, with those of the debris, sum to the body's within 1e-9 of it.
    pub fragments: Vec<Fragment>,
    /// Where each fragment comes from; empty where that is not known.
    pub origins: Vec<FragmentOrigin>,
    /// Parts too small to be fragments.
    pub debris: Vec<Grain>,
    /// Impulse that each support of the problem gave along its normal \[N·s\], not negative; empty
    /// where the method knows no supports.
    pub reactions: Vec<f64>,
    /// What it cost.
    pub report: Report,
}

/// A body of a new shape, in its frame before the hit. Its mass is the old one's.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// The new shape \[m\].
    pub body: BodyShape,
    /// Convex parts that stand in for it in collisions: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// Velocity of its centroid that the hit gave it, beside the body's motion before the hit
    /// \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity that the hit gave it, likewise \[rad/s\].
    pub spin: Vec3,
    /// What the deformation cost, paid from the hit: plastic work and cracks that part nothing
    /// \[J\].
    pub work: f64,
    /// As [`Fragmentation::reactions`].
    pub reactions: Vec<f64>,
    /// What it cost.
    pub report: Report,
}

/// The result of a solve.
#[derive(Clone, Debug, PartialEq)]
pub enum SolveOutcome {
    /// The body is in parts.
    Broken(Box<Fragmentation>),
    /// It is one body still, of another shape.
    Deformed(Box<Deformation>),
    /// It is as it was: the one fragment is the whole body, with the cracks that end inside it.
    Unchanged(Box<Fragmentation>),
}

impl SolveOutcome {
    /// What the solve cost and what it found out.
    #[must_use]
    pub fn report(&self) -> &Report {
        match self {
            Self::Broken(fracture) | Self::Unchanged(fracture) => &fracture.report,
            Self::Deformed(deformation) => &deformation.report,
        }
    }

    /// The same, to be added to.
    pub fn report_mut(&mut self) -> &mut Report {
        match self {
            Self::Broken(fracture) | Self::Unchanged(fracture) => &mut fracture.report,
            Self::Deformed(deformation) => &mut deformation.report,
        }
    }

    /// How many bodies there are afterwards, debris aside.
    #[must_use]
    pub fn bodies(&self) -> usize {
        match self {
            Self::Broken(fracture) | Self::Unchanged(fracture) => fracture.fragments.len(),
            Self::Deformed(_) => 1,
        }
    }

    /// The parts, or the whole as one part; nothing of a body that was deformed.
    #[must_use]
    pub fn fracture(self) -> Option<Fragmentation> {
        match self {
            Self::Broken(fracture) | Self::Unchanged(fracture) => Some(*fracture),
            Self::Deformed(_) => None,
        }
    }
}

impl Fragmentation {
    /// Whether nothing separated.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.fragments.len() <= 1 && self.debris.is_empty()
    }

    /// How much of it was solved, sampled and directed: `None` where that is not known of each
    /// fragment. A crack has two faces, and each counts for the part that it belongs to.
    #[must_use]
    pub fn shares(&self) -> Option<SolvedShares> {
        if self.origins.len() != self.fragments.len() {
            return None;
        }
        let mut shares = SolvedShares::default();
        for (fragment, origin) in self.fragments.iter().zip(&self.origins) {
            let volume = fragment.solid.mesh.signed_volume();
            let area = 0.5 * crack_faces(&fragment.solid);
            let own = match origin {
                FragmentOrigin::Solved => &mut shares.solved,
                FragmentOrigin::Sampled => &mut shares.sampled,
                FragmentOrigin::Directed => &mut shares.directed,
            };
            own.volume += volume;
            own.crack_area += area;
        }
        shares.sampled.volume += self.debris.iter().map(|grain| grain.volume).sum::<f64>();
        Some(shares)
    }
}

/// Area of the crack faces that this fracture made: those of earlier ones name their body
/// \[m²\].
fn crack_faces(solid: &Solid) -> f64 {
    let new = |&(_, mark): &(usize, &Surface)| matches!(mark, Surface::Crack { parent: 0, .. });
    let twice = |(t, _): (usize, _)| {
        let [a, b, c] = solid.mesh.corners(t);
        (b - a).cross(&(c - a)).norm()
    };
    0.5 * solid.surface.iter().enumerate().filter(new).map(twice).sum::<f64>()
}

/// An amount of a broken body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amount {
    /// Volume \[m³\].
    pub volume: f64,
    /// Crack area, half of that of the faces \[m²\].
    pub crack_area: f64,
}

/// How much of what broke was solved from stress, sampled from a law, or directed by the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolvedShares {
    /// Solved.
    pub solved: Amount,
    /// Sampled; debris is.
    pub sampled: Amount,
    /// Directed: fragments that were divided or joined because the scene asked for it.
    pub directed: Amount,
}

impl From<Fragmentation> for SolveOutcome {
    fn from(fracture: Fragmentation) -> Self {
        match fracture.is_intact() {
            true => Self::Unchanged(Box::new(fracture)),
            false => Self::Broken(Box::new(fracture)),
        }
    }
}
