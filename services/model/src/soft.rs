//! What a body with a closed surface is that moves as it deforms: a soft shell or a soft solid.
//!
//! Places in it are in its own frame, which its pose puts into the world.

use crate::{BondedSolid, Hardening, Material, MembranePace, SheetAir};
use cullet_geometry::{Pose, Solid, Vec3};
use std::sync::Arc;

/// A soft shell or a soft solid.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SoftBody {
    /// What it fills at rest, in its own frame \[m\]: of a shell, its wall. It travels beside the
    /// numbers.
    #[cfg_attr(feature = "wire", serde(skip))]
    pub solid: Arc<Solid>,
    /// Its elasticity, σ_f and G_f.
    pub material: Material,
    /// What it is solved as, and how it yields and breaks.
    pub law: SoftLaw,
    /// Distance of its points or control points \[m\].
    pub spacing: f64,
    /// Share of critical damping that its fastest motion has \[1\].
    pub damping: f64,
    /// Puts its frame into the world.
    pub pose: Pose,
    /// How it moves at first \[m/s\].
    pub velocity: Vec3,
    /// How it turns at first about its frame's origin, in the world's axes \[rad/s\].
    pub spin: Vec3,
    /// What holds it.
    pub grips: Vec<BodyGrip>,
    /// What it is cut along before anything happens.
    pub cuts: Vec<BodyCut>,
    /// The air around it.
    pub air: SheetAir,
    /// How fast its waves are allowed to be.
    pub pace: MembranePace,
}

/// What a soft body is solved as.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum SoftLaw {
    /// A thin wall: neo-Hookean in plane stress. Without hardening it does not yield.
    Shell {
        /// How it yields; `None` where it does not.
        hardening: Option<Hardening>,
        /// Whether it tears.
        breaks: bool,
    },
    /// Points that are bonded to those around them.
    Bonded(BondedSolid),
}

/// Part of a body, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum BodyRegion {
    /// Around a place \[m\].
    Ball {
        /// Its centre.
        centre: Vec3,
        /// Its radius \[m\].
        radius: f64,
    },
    /// Between two corners \[m\].
    Box {
        /// The least coordinates.
        low: Vec3,
        /// The greatest.
        high: Vec3,
    },
}

impl BodyRegion {
    /// Whether a place is in it.
    #[must_use]
    pub fn has(&self, place: &Vec3) -> bool {
        match self {
            Self::Ball { centre, radius } => (place - centre).norm_squared() <= radius * radius,
            Self::Box { low, high } => (0..3).all(|k| (low[k]..=high[k]).contains(&place[k])),
        }
    }

    /// Its middle \[m\].
    #[must_use]
    pub fn middle(&self) -> Vec3 {
        match self {
            Self::Ball { centre, .. } => *centre,
            Self::Box { low, high } => 0.5 * (low + high),
        }
    }
}

/// Something that holds part of a body and may lead it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyGrip {
    /// What it holds.
    pub region: BodyRegion,
    /// When \[s\] it is how far \[m\] from where it began, in the world's axes, straight between
    /// the rows; it stays at the last. Without rows it stays where it is.
    pub path: Vec<(f64, Vec3)>,
    /// How it turns about the middle of its region, in the world's axes, as long as it moves: until
    /// the last row's time, or for good without rows \[rad/s\].
    pub turn: Vec3,
    /// When it lets go \[s\].
    pub until: Option<f64>,
}

/// Where a body is cut before anything happens, in its own frame: a polygon \[m\] that parts what
/// lies on its two sides. Of a shell, what it crosses of the midsurface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyCut {
    /// Its corners, in order, in one plane; it is as a fan of triangles from the first.
    pub corners: Vec<Vec3>,
}

impl BodyCut {
    /// Whether the line from one place to another goes through it.
    #[must_use]
    pub fn parts(&self, from: &Vec3, to: &Vec3) -> bool {
        let Some((first, rest)) = self.corners.split_first() else { return false };
        rest.windows(2).any(|two| crosses([first, &two[0], &two[1]], from, to))
    }
}

/// Whether a line goes through a triangle: one end on each side of its plane (an end in the plane
/// counts as above it), and the line on the same side of all its edges.
fn crosses([a, b, c]: [&Vec3; 3], from: &Vec3, to: &Vec3) -> bool {
    let normal = (b - a).cross(&(c - a));
    let (below, above) = ((from - a).dot(&normal), (to - a).dot(&normal));
    if (below < 0.0) == (above < 0.0) {
        return false;
    }
    let along = to - from;
    let side = |p: &Vec3, q: &Vec3| (p - from).cross(&(q - from)).dot(&along);
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

impl SoftBody {
    /// Its numbers: what each is, its value, the least and the greatest that holds.
    #[must_use]
    pub fn bounds(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let Material { density, young, poisson, failure_stress, fracture_energy } = self.material;
        let mut all = vec![
            ("density of a soft body [kg/m³]", density, 1.0, 3e4),
            ("Young's modulus of a soft body [Pa]", young, 1.0, 1e13),
            ("Poisson's ratio of a soft body [1]", poisson, 0.0, 0.495),
            ("strength of a soft body [Pa]", failure_stress, 1e-3, 1e12),
            ("fracture energy of a soft body [J/m²]", fracture_energy, 1e-3, 1e9),
            ("spacing of a soft body [m]", self.spacing, 1e-6, 1e3),
            ("damping of a soft body [1]", self.damping, 0.0, 1.0),
        ];
        match &self.law {
            SoftLaw::Shell { hardening, .. } => {
                all.extend(hardening.iter().flat_map(Hardening::bounds));
            }
            SoftLaw::Bonded(bonds) => all.extend(bonds.bounds()),
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::{BodyCut, BodyRegion};
    use cullet_geometry::Vec3;

    #[test]
    fn a_cut_parts_what_it_lies_between_and_nothing_else() {
        let corner = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let square = vec![corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 2.0), corner(0.0, 2.0)];
        let cut = BodyCut { corners: square };
        for (x, y, through) in
            [(0.5, 0.4, true), (1.5, 1.6, true), (1.0, 1.0, true), (2.5, 1.0, false)]
        {
            let (below, above) = (Vec3::new(x, y, -1.0), Vec3::new(x, y, 0.5));
            assert_eq!(cut.parts(&below, &above), through, "{x} {y}");
            assert_eq!(cut.parts(&above, &below), through, "{x} {y}");
            assert!(!cut.parts(&above, &Vec3::new(x, y, 0.1)), "{x} {y}");
        }
        assert!(!BodyCut { corners: vec![] }.parts(&Vec3::zeros(), &Vec3::z()));
    }

    #[test]
    fn regions_know_what_is_in_them() {
        let ball = BodyRegion::Ball { centre: Vec3::x(), radius: 1.0 };
        assert!(ball.has(&Vec3::zeros()) && !ball.has(&Vec3::y()));
        let block = BodyRegion::Box { low: -Vec3::x(), high: Vec3::y() };
        assert!(block.has(&Vec3::new(-0.5, 0.5, 0.0)) && !block.has(&Vec3::z()));
        assert_eq!(block.middle(), Vec3::new(-0.5, 0.5, 0.0));
    }
}
