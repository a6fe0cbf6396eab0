//! How a specimen lies on the grid.

use crate::problem::SpecimenBody;
use cullet_geometry::{Quat, Vec3};

/// From the specimen's frame to the one that a family solves in, and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridFrame {
    turn: Quat,
    shift: Vec3,
}

impl Default for GridFrame {
    /// The specimen's own.
    fn default() -> Self {
        Self { turn: Quat::identity(), shift: Vec3::zeros() }
    }
}

impl GridFrame {
    /// The frame of the grid that a body lies on.
    #[must_use]
    pub fn new(body: &SpecimenBody) -> Self {
        Self { turn: body.turn, shift: body.shift }
    }

    /// By a turn and, after it, a shift \[m\].
    #[must_use]
    pub fn from_parts(turn: Quat, shift: Vec3) -> Self {
        Self { turn, shift }
    }

    /// A place of the specimen on the grid \[m\].
    #[must_use]
    pub fn onto(&self, x: &Vec3) -> Vec3 {
        self.turn * x + self.shift
    }

    /// A place of the grid in the specimen \[m\].
    #[must_use]
    pub fn back(&self, x: &Vec3) -> Vec3 {
        self.turn.inverse() * (x - self.shift)
    }

    /// A direction of the specimen on the grid.
    #[must_use]
    pub fn turned(&self, v: &Vec3) -> Vec3 {
        self.turn * v
    }

    /// A direction of the grid in the specimen.
    #[must_use]
    pub fn unturned(&self, v: &Vec3) -> Vec3 {
        self.turn.inverse() * v
    }

    /// Whether both have the same axes.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        self.turn.angle() < 1e-12
    }
}
