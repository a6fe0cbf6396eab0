//! What a thin sheet is: its outline, what it is made of, what holds it, what it takes up.
//!
//! Places in the sheet are in its own plane: two coordinates \[m\], which its pose puts into the
//! world. Han and others' membrane of points and bonds, corrected; see docs/departures.md.

use cullet_geometry::{Pose, Vec3};

/// A place in a sheet's own plane \[m\].
pub type SheetPlace = [f64; 2];

/// A thin sheet.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct MembraneSheet {
    /// Its outline: a polygon that does not cross itself, counter-clockwise \[m\].
    pub outline: Vec<SheetPlace>,
    /// Lines along which it is cut before anything happens \[m\].
    pub notches: Vec<Vec<SheetPlace>>,
    /// \[m\].
    pub thickness: f64,
    /// Distance of its points \[m\].
    pub spacing: f64,
    /// Reach of its bonds over the spacing \[1\].
    pub horizon: f64,
    /// What it is made of.
    pub material: MembraneMaterial,
    /// Puts its plane into the world: the sheet's z is its normal.
    pub pose: Pose,
    /// How it moves at first \[m/s\].
    pub velocity: Vec3,
    /// What holds it.
    pub grips: Vec<SheetGrip>,
    /// The air around it.
    pub air: SheetAir,
    /// What it takes up.
    pub diffusion: SheetQuantities,
    /// Stiffness by area of a base that pulls each point back to where it is at rest \[Pa/m\].
    pub foundation: Option<f64>,
    /// How fast its waves are allowed to be.
    pub pace: MembranePace,
}

/// What a sheet is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct MembraneMaterial {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// E \[Pa\].
    pub young: f64,
    /// ν \[1\].
    pub poisson: f64,
    /// G: work of a crack by its area at rest \[J/m²\].
    pub fracture_energy: f64,
    /// σ_t of a brittle sheet, σ_y of a foil \[Pa\]; rubber softens as a brittle sheet.
    pub strength: f64,
    /// How its bonds stretch.
    pub law: MembraneLaw,
    /// Standard deviation of the stretch at which bonds break, over its mean \[1\].
    pub scatter: f64,
    /// Thickness by which it bends, at least, over the spacing: η \[1\].
    pub bending_floor: f64,
    /// ζ: share of critical damping that bonds give their fastest motion \[1\].
    pub damping: f64,
}

/// How the bonds of a sheet stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum MembraneLaw {
    /// Elastic until they soften.
    Brittle,
    /// They flow, harden not, and tear.
    Foil,
    /// Elastic to large stretches.
    Rubber,
}

/// Part of a sheet, in its own plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum SheetRegion {
    /// Around a place \[m\].
    Disc {
        /// Its centre.
        centre: SheetPlace,
        /// Its radius \[m\].
        radius: f64,
    },
    /// Between two corners \[m\].
    Box {
        /// The least coordinates.
        low: SheetPlace,
        /// The greatest.
        high: SheetPlace,
    },
}

impl SheetRegion {
    /// Whether a place is in it.
    #[must_use]
    pub fn has(&self, [x, y]: SheetPlace) -> bool {
        match self {
            Self::Disc { centre: [a, b], radius } => {
                (x - a) * (x - a) + (y - b) * (y - b) <= radius * radius
            }
            Self::Box { low, high } => {
                (low[0]..=high[0]).contains(&x) && (low[1]..=high[1]).contains(&y)
            }
        }
    }
}

/// Something that holds part of a sheet and may lead it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SheetGrip {
    /// What it holds.
    pub region: SheetRegion,
    /// When \[s\] it is how far \[m\] from where it began, straight between the rows; it stays at
    /// the last. Without rows it stays where it is.
    pub path: Vec<(f64, Vec3)>,
    /// When it lets go \[s\].
    pub until: Option<f64>,
}

/// The air around a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SheetAir {
    /// \[kg/m³\].
    pub density: f64,
    /// Of its drag by the area that meets it \[1\].
    pub drag: f64,
    /// \[m/s\].
    pub wind: Vec3,
    /// Greatest gust over the wind \[1\], and how often in a second it comes \[1/s\].
    pub gusts: [f64; 2],
    /// Pressure on its lower side, less that on its upper \[Pa\].
    pub pressure: f64,
}

/// The quantities that spread in a sheet. Each has its own θ and spreads by itself; what they do to
/// the sheet comes together: shares that are left multiply, strains and masses add.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
// What is beside a first one travels behind the body's numbers: bodies with one keep their digests.
#[cfg_attr(feature = "wire", serde(from = "FirstQuantity", into = "FirstQuantity"))]
pub struct SheetQuantities {
    /// What each is.
    pub all: Vec<SheetDiffusion>,
    /// What each is called; [`FIRST_QUANTITY`] where nothing stands here.
    pub names: Vec<String>,
    /// Number of the one whose θ frames carry.
    pub shown: u32,
}

/// The first of a sheet's quantities, if there is one: what stands among the body's numbers.
type FirstQuantity = Option<SheetDiffusion>;

/// What a sheet's quantities are beside the first of them.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct FurtherQuantities {
    /// All but the first.
    pub all: Vec<SheetDiffusion>,
    /// What all are called.
    pub names: Vec<String>,
    /// Number of the one whose θ frames carry.
    pub shown: u32,
}

/// Name of a quantity that was not given one.
pub const FIRST_QUANTITY: &str = "quantity";
/// Most quantities that spread in one sheet.
pub const MOST_QUANTITIES: usize = 4;

impl SheetQuantities {
    /// Whether nothing spreads.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// What a quantity is called.
    #[must_use]
    pub fn name(&self, number: usize) -> &str {
        self.names.get(number).map_or(FIRST_QUANTITY, String::as_str)
    }

    /// What there is beside the first, if there is anything.
    #[must_use]
    pub fn further(&self) -> Option<FurtherQuantities> {
        let all = self.all.get(1..).unwrap_or_default().to_vec();
        let further = FurtherQuantities { all, names: self.names.clone(), shown: self.shown };
        (further != FurtherQuantities::default()).then_some(further)
    }

    /// Puts beside the first what there is beside it.
    pub fn join(&mut self, further: FurtherQuantities) {
        self.all.truncate(1);
        self.all.extend(further.all);
        (self.names, self.shown) = (further.names, further.shown);
    }

    /// Strain along x and y by all of them, each at its θ \[1\].
    #[must_use]
    pub fn strains(&self, theta: impl IntoIterator<Item = f64>) -> [f64; 2] {
        let own = self.all.iter().zip(theta).map(|(what, theta)| what.strains(theta));
        own.fold([0.0; 2], |[x, y], [along, across]| [x + along, y + across])
    }

    /// Whether what a rigid body touches takes one up: windows then say of which object of the
    /// scene each body is.
    #[must_use]
    pub fn asks_for_objects(&self) -> bool {
        let by_contact =
            |source: &SheetSource| matches!(source.kind, SheetSourceKind::Contact { .. });
        self.all.iter().flat_map(|what| &what.sources).any(by_contact)
    }
}

impl From<FirstQuantity> for SheetQuantities {
    fn from(first: FirstQuantity) -> Self {
        Self { all: first.into_iter().collect(), ..Self::default() }
    }
}

impl From<SheetQuantities> for FirstQuantity {
    fn from(quantities: SheetQuantities) -> Self {
        quantities.all.into_iter().next()
    }
}

/// A quantity that spreads in a sheet, and what that does to it. θ is what it is measured in: K, or
/// kg of water by kg of the dry sheet.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SheetDiffusion {
    /// ρC: what a volume takes up for θ to grow by 1 \[J/(m³·K), or 1 by θ\].
    pub capacity: f64,
    /// K along the sheet's x and y \[W/(m·K), or m²/s times the capacity\].
    pub conductivity: [f64; 2],
    /// β: strain by θ along x and y \[1/θ\].
    pub expansion: [f64; 2],
    /// θ before anything happens; what it does is counted from there.
    pub start: f64,
    /// θ at which it takes up no more.
    pub saturation: f64,
    /// Share of E that is left over θ: rows (θ, share), straight between them \[1\].
    pub stiffness: Vec<(f64, f64)>,
    /// Share of G that is left, likewise \[1\].
    pub toughness: Vec<(f64, f64)>,
    /// Share of the strength that is left, likewise \[1\].
    pub strength: Vec<(f64, f64)>,
    /// Rate at which θ − θ₀ eats away at G for good: ẇ = r (θ − θ₀) and G falls by e^−w
    /// \[1/(s·θ)\].
    pub exposure: f64,
    /// Mass by θ that it gains, by volume of the sheet \[kg/(m³·θ)\].
    pub weight: f64,
    /// ε_v: loss to the air by area and θ − θ_air \[W/(m²·K), or m/s times the capacity\].
    pub loss: f64,
    /// θ of the air.
    pub ambient: f64,
    /// Where it comes from.
    pub sources: Vec<SheetSource>,
}

/// Where something comes into a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SheetSource {
    /// Where.
    pub region: SheetRegion,
    /// From when \[s\].
    pub from: f64,
    /// Until when \[s\].
    pub until: f64,
    /// How.
    pub kind: SheetSourceKind,
}

/// How something comes into a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum SheetSourceKind {
    /// θ is held there.
    Held(f64),
    /// By area and time \[W/m², or θ times the capacity by m·s\].
    Flux(f64),
    /// Through a film, towards this θ \[θ\], by area, time and difference \[W/(m²·K)\].
    Film(f64, f64),
    /// Through a film, where and while a rigid body of an object of the scene touches it.
    Contact {
        /// Number of the object in the scene; its fragments count as it does.
        object: u32,
        /// θ of the body, which stays as it is.
        towards: f64,
        /// By area, time and difference \[W/(m²·K)\].
        film: f64,
    },
}

/// How fast the waves of a sheet are, so that steps are long enough.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum MembranePace {
    /// As they are.
    Real,
    /// By a softer sheet, to this speed \[m/s\]: fracture energy, bending and weight stay.
    Softer(f64),
    /// By a heavier sheet, to this speed \[m/s\]: stiffness and weight stay, inertia grows.
    Heavier(f64),
}

impl MembraneMaterial {
    /// Its numbers: what each is, its value, the least and the greatest that holds.
    #[must_use]
    pub fn bounds(&self) -> Vec<(&'static str, f64, f64, f64)> {
        vec![
            ("density of a sheet [kg/m³]", self.density, 1.0, 3e4),
            ("Young's modulus of a sheet [Pa]", self.young, 1.0, 1e13),
            ("Poisson's ratio of a sheet [1]", self.poisson, 0.0, 0.5),
            ("fracture energy of a sheet [J/m²]", self.fracture_energy, 1e-3, 1e9),
            ("strength of a sheet [Pa]", self.strength, 1e-3, 1e12),
            ("scatter of a sheet's strength [1]", self.scatter, 0.0, 0.5),
            ("least bending thickness over the spacing [1]", self.bending_floor, 0.0, 2.0),
            ("damping of a sheet's bonds [1]", self.damping, 0.0, 1.0),
        ]
    }
}
