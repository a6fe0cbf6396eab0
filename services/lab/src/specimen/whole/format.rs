//! The file of a specimen of the whole as it is written.

use super::super::format::{Component, Ends, Expected, Metric};
use cullet_document::unit;
use cullet_scene::format::Document as Scene;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A specimen of the whole: a scene that is run as any other, what is watched, and what must come
/// out.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SceneBenchmarkDocument {
    /// What it shows, in a line.
    pub description: String,
    /// Files read before this one, relative to it. This file's values win.
    #[schemars(length(max = 64))]
    pub include: Vec<String>,
    /// The scene, with the keys of a scene file; its `include` brings in one that is there. Its
    /// `expect` is for other commands.
    pub scene: Scene,
    /// How it must end.
    pub run: SceneRunConfig,
    /// Numbers read after each step of the world.
    pub probe: Vec<SceneProbeConfig>,
    /// Numbers made of them.
    pub metric: Vec<Metric>,
    /// What metrics must come to, by name.
    pub expect: BTreeMap<String, Expected>,
}

/// How it must end.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[schemars(rename = "Run")]
#[serde(deny_unknown_fields, default)]
pub struct SceneRunConfig {
    /// How it must end.
    pub ends: Ends,
}

/// What a probe watches. A body is all that came of it: fragments and grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[schemars(rename = "ProbeKind")]
#[serde(rename_all = "kebab-case")]
pub enum SceneProbeKind {
    /// Centre of mass \[m\]: `body`, `component`.
    Position,
    /// How far from where it was first, of several the farthest \[m\]: `body`, `component`.
    Displacement,
    /// Velocity of the centre of mass \[m/s\]: `body`, `component`.
    Velocity,
    /// Angular velocity of a body that is whole \[rad/s\]: `body`, `component`.
    Spin,
    /// Mass \[kg\]: `body`.
    Mass,
    /// Volume \[m³\]: `body`.
    Volume,
    /// Moments of inertia about the centre of mass, of parts by the parallel axes \[kg m²\]:
    /// `body`, `component`.
    Inertia,
    /// Momentum \[kg m/s\]: `body`, `component`.
    Momentum,
    /// Angular momentum about the world's origin \[kg m²/s\]: `body`, `component`.
    AngularMomentum,
    /// Kinetic energy \[J\]: `body`.
    Kinetic,
    /// Potential energy, 0 at the world's origin \[J\]: `body`.
    Potential,
    /// Both \[J\]: `body`.
    Energy,
    /// Energy that hits took so far, but those that broke a body \[J\]: `body`.
    HitLoss,
    /// Kinetic energy that went when bodies broke so far, with the hits that broke them and all
    /// cracks \[J\]: `body`.
    BreakLoss,
    /// G_f times the area of all cracks so far \[J\]: `body`.
    CrackEnergy,
    /// Energy that is there or went in a known way, less that at the start \[J\].
    Balance,
    /// Worst relative error of mass of a break so far, in the world's books \[1\]: `body`.
    MassError,
    /// That of volume \[1\]: `body`.
    VolumeError,
    /// That of the momentum of all that took part \[1\]: `body`.
    MomentumError,
    /// That of the angular momentum \[1\]: `body`.
    AngularMomentumError,
    /// Greatest relative gain of kinetic energy of a break so far, cracks paid \[1\]: `body`.
    EnergyGain,
    /// Bodies there are \[1\]: `body`.
    Bodies,
    /// Parts of at least `share` of its mass \[1\]: `body`, `share`.
    Pieces,
    /// Share of its mass that the largest part has \[1\]: `body`.
    Largest,
    /// Breaks so far \[1\]: `body`.
    Breaks,
    /// Solves so far after which a body stayed whole \[1\]: `body`.
    Kept,
    /// Solves so far that all solvers declined \[1\]: `body`.
    Refused,
    /// Solves so far that failed \[1\]: `body`.
    Failed,
    /// Hits of `body` so far, by `other` \[1\].
    Hits,
    /// Which hit of the run that of `body` was: 1 is the first \[1\]; this and all that follow:
    /// `body`, `other`, `nth`; no number before it.
    HitOrder,
    /// When it was told \[s\].
    HitTime,
    /// Closing speed \[m/s\].
    HitSpeed,
    /// Impulse \[N s\].
    HitImpulse,
    /// Kinetic energy of the approach \[J\].
    HitEnergy,
    /// Energy that it took \[J\].
    HitTook,
    /// Effective mass, 2E/v² \[kg\].
    HitMass,
    /// Duration by Hertz \[s\].
    HitDuration,
    /// Contact radius by Hertz \[m\].
    HitRadius,
    /// Force by Hertz \[N\].
    HitForce,
}

/// A number that is read after each step. `kind` says which of the other keys it takes.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Probe")]
#[serde(deny_unknown_fields)]
pub struct SceneProbeConfig {
    /// What metrics call it, and the head of its column.
    pub name: String,
    /// What it watches.
    pub kind: SceneProbeKind,
    /// A body of the scene, or all bodies that a grid, stack or scatter of that name made; all that
    /// are not fixed without it.
    #[serde(default)]
    pub body: Option<String>,
    /// What hits it, named likewise; anything without it.
    #[serde(default)]
    pub other: Option<String>,
    /// Which number of a vector, or of the moments of inertia.
    #[serde(default)]
    pub component: Option<Component>,
    /// Which of the hits, the first without it.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub nth: Option<u32>,
    /// Least share of its mass that a part needs to be counted: 0 without it \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub share: Option<f64>,
}
