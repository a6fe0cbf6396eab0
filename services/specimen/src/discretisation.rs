//! What a family of solvers does for specimens: the body made discrete, a step at a time.
//!
//! The run tells a [`Discretisation`] the step and the factor of each load and support, and reads
//! off it sums and what points carry. Nothing else is asked, so that every family is compared with
//! the same formulas by the same specimens.

use crate::frame::GridFrame;
use crate::probe::PointField;
use cullet_geometry::symmetric::Sym3;
use cullet_geometry::{Mat3, Vec3};
use std::collections::BTreeMap;
use std::fmt::Debug;

/// A specimen that a family has made discrete, with its loads and supports attached. Vectors and
/// tensors are in the frame of [`Discrete::frame`].
pub trait Discretisation: Debug {
    /// Takes one step.
    fn step(&mut self, drive: &Drive<'_>) -> StepTally;

    /// Sums over the whole body now.
    fn sums(&self) -> BodySums;

    /// What points carry now. Only fields that the family says that it has are asked for.
    fn points(&self, fields: &[PointField]) -> PointFields;

    /// Shares of the body's mass that its pieces have now, the largest first \[1\].
    fn pieces(&self) -> Vec<f64>;
}

/// A discretisation, and what is known of it before it moves.
#[derive(Debug)]
pub struct Discrete {
    /// It.
    pub body: Box<dyn Discretisation>,
    /// Its points.
    pub points: u64,
    /// Its greatest stable step \[s\].
    pub stable_step: f64,
    /// Stress at which cracks grow over σ_f \[1\]; 1 where a family has no cracks.
    pub strength_ratio: f64,
    /// From the specimen's frame to its own.
    pub frame: GridFrame,
    /// The force of each load at 1 of its course \[N\].
    pub loads: Vec<Vec3>,
}

/// What drives one step.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// Time step \[s\].
    pub step: f64,
    /// Factor of each load at the start of the step \[1\].
    pub loads: &'a [f64],
    /// Factor of each support at the end of the step \[1\]; none where it has let go.
    pub holds: &'a [Option<f64>],
    /// Rate at which velocities fall off by themselves in this step \[1/s\].
    pub damping: f64,
}

/// What a step did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepTally {
    /// Energy that the material lost, to damage or to flow \[J\].
    pub dissipated: f64,
    /// Energy that damping took \[J\].
    pub damped: f64,
    /// Energy lost where sides of cracks, or bodies, met \[J\].
    pub met: f64,
    /// Work of the loads \[J\].
    pub pushed: f64,
    /// Work of the supports \[J\].
    pub held: f64,
    /// Force of each support on the body, mean over the step \[N\]; zero where it has let go.
    pub reactions: Vec<Vec3>,
    /// Why the family does not hold for the body any more, if so: the run ends with it.
    pub limit: Option<String>,
}

/// Sums over the whole body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySums {
    /// Kinetic energy \[J\].
    pub kinetic: f64,
    /// Elastic energy \[J\].
    pub elastic: f64,
    /// Linear momentum \[kg·m/s\].
    pub momentum: Vec3,
    /// Angular momentum about the origin of its frame \[kg·m²/s\].
    pub angular_momentum: Vec3,
    /// Whether every number of its state is one (F76).
    pub finite: bool,
}

/// A vector at a point, and how it goes on from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalVector {
    /// At the point.
    pub value: Vec3,
    /// Its gradient by the place before anything moved; zero where a family has none \[1/m\].
    pub gradient: Mat3,
}

/// A field at each point.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValues {
    /// Of a number.
    Numbers(Vec<f64>),
    /// Of a vector.
    Vectors(Vec<LocalVector>),
    /// Of a symmetric tensor.
    Tensors(Vec<Sym3>),
}

/// What points carry, one beside the other, in any order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFields {
    /// Where each was before anything moved \[m\].
    pub places: Vec<Vec3>,
    /// The number of each from 0 on, which it keeps when the order changes.
    pub numbers: Vec<u32>,
    /// Volume of each \[m³\].
    pub volumes: Vec<f64>,
    /// What was asked for.
    pub fields: BTreeMap<PointField, FieldValues>,
}
