//! What is watched, what is made of it, and what must come out, as it is written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// What a probe watches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProbeKind {
    /// Displacement of points \[m\]: `component`; `at`, or `region` and `reduce`.
    Displacement,
    /// Velocity of points \[m/s\]: likewise.
    Velocity,
    /// Stress of points \[Pa\], second Piola-Kirchhoff as weakened by damage: likewise.
    Stress,
    /// Green's strain of points \[1\]: likewise.
    Strain,
    /// Damage of points \[1\]: likewise, without `component`.
    Damage,
    /// Equivalent plastic strain of points \[1\]: likewise, without `component`.
    PlasticStrain,
    /// Volume of points over that at rest \[1\]: likewise, without `component`.
    VolumeRatio,
    /// Force of `support` on the specimen, mean between samples \[N\]: `component`.
    Reaction,
    /// Force of `load` \[N\]: `component`.
    Applied,
    /// Kinetic energy \[J\].
    Kinetic,
    /// Elastic energy \[J\].
    Elastic,
    /// Energy lost to damage \[J\].
    Dissipated,
    /// Energy that damping took \[J\].
    Damped,
    /// Energy lost where sides of cracks, or bodies, met \[J\].
    Contact,
    /// Work of all loads and supports \[J\].
    Work,
    /// Energy that is there or was lost in a known way, less what was there and was put in \[J\].
    Balance,
    /// Momentum \[kg m/s\]: `component`.
    Momentum,
    /// Angular momentum about the specimen's origin \[kg m²/s\]: `component`.
    AngularMomentum,
    /// Fully broken points of `region` \[1\].
    Broken,
    /// Volume of the points of `region` with damage above `threshold` \[m³\].
    DamagedVolume,
    /// Area across `direction` of the squares of one spacing that broken points of `region` lie in
    /// \[m²\].
    CrackArea,
    /// How far broken points of `region` reach along `direction`, all but a `share` of them \[m\];
    /// `otherwise` before there are any.
    CrackTip,
    /// Speed of that tip, over the last `window` \[m/s\]: `region`, `direction`, `share`,
    /// `otherwise`.
    CrackSpeed,
    /// Angle of the mean of the broken points of `region` about the place `at`, from `direction`
    /// towards `towards` \[rad\].
    CrackAngle,
    /// Pieces of at least `share` of the body \[1\].
    Pieces,
    /// Share of the body that the largest piece has \[1\].
    Largest,
}

/// One number of a vector or tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Component {
    /// Of a vector.
    X,
    /// Of a vector.
    Y,
    /// Of a vector.
    Z,
    /// Length of a vector, norm of a tensor.
    Size,
    /// Of a tensor.
    Xx,
    /// Of a tensor.
    Yy,
    /// Of a tensor.
    Zz,
    /// Of a tensor.
    Xy,
    /// Of a tensor.
    Yz,
    /// Of a tensor.
    Zx,
    /// Greatest principal value.
    Greatest,
    /// Least principal value.
    Least,
    /// Von Mises' equivalent.
    Mises,
    /// A third of the trace.
    Mean,
}

/// What becomes of the numbers of many points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[schemars(rename = "Reduce")]
#[serde(rename_all = "kebab-case")]
pub enum ReduceChoice {
    /// Their mean by volume.
    #[default]
    Mean,
    /// The greatest.
    Max,
    /// The least.
    Min,
}

/// A number that is sampled in time. `kind` says which of the other keys it takes.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Probe")]
#[serde(deny_unknown_fields)]
pub struct ProbeConfig {
    /// What metrics call it, and the head of its column.
    pub name: String,
    /// What it watches.
    pub kind: ProbeKind,
    /// Which number of a vector or tensor.
    #[serde(default)]
    pub component: Option<Component>,
    /// The place of one point \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length3")]
    pub at: Option<[f64; 3]>,
    /// All points of a region; `all` without it.
    #[serde(default)]
    pub region: Option<String>,
    /// What becomes of their numbers.
    #[serde(default)]
    pub reduce: Option<ReduceChoice>,
    /// Name of a support.
    #[serde(default)]
    pub support: Option<String>,
    /// Name of a load.
    #[serde(default)]
    pub load: Option<String>,
    /// Damage above which a point counts: 0.05 without it \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub threshold: Option<f64>,
    /// A direction; need not have length 1.
    #[serde(default)]
    pub direction: Option<[f64; 3]>,
    /// The direction of a quarter of a turn; need not have length 1.
    #[serde(default)]
    pub towards: Option<[f64; 3]>,
    /// Of broken points that may lie ahead of the tip, 0.02 without it; of a body that is a piece,
    /// 0.01 without it \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub share: Option<f64>,
    /// Where the tip is before anything broke: 0 without it \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length")]
    pub otherwise: Option<f64>,
    /// Over how long a speed is taken \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0))]
    pub window: Option<f64>,
}

/// How one number is made of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reduction {
    /// The first sample.
    First,
    /// The last.
    Final,
    /// The greatest.
    Max,
    /// The least.
    Min,
    /// The greatest size.
    MaxSize,
    /// Greatest less least.
    Range,
    /// Mean by time.
    Mean,
    /// Integral over time.
    Integral,
    /// Between samples, at `time`.
    At,
    /// When the greatest was sampled \[s\].
    TimeOfMax,
    /// When the least was \[s\].
    TimeOfMin,
    /// When it first reached `threshold`, between samples \[s\].
    TimeReached,
    /// How long it was at or above `threshold` \[s\].
    TimeAbove,
    /// Slope of the straight line of least squares \[1/s\].
    Slope,
    /// Greatest slope of such a line over any `window` \[1/s\].
    MaxSlope,
    /// Time between every second crossing of its mean \[s\].
    Period,
    /// Logarithm of the ratio of successive maxima, mean over all \[1\].
    Decrement,
    /// Last less first, over the greatest size \[1\].
    Drift,
    /// Slope of the straight line of least squares through the logarithms of time and value: p
    /// where the values go as tᵖ \[1\].
    Exponent,
}

/// A number made of the samples of a probe.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Metric {
    /// What `[expect]` calls it.
    pub name: String,
    /// The probe.
    pub probe: String,
    /// How the values of the points become one number.
    pub reduce: Reduction,
    /// Earlier samples are left out \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time")]
    pub from: Option<f64>,
    /// Later samples are left out \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time")]
    pub until: Option<f64>,
    /// The moment of `at` \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time")]
    pub time: Option<f64>,
    /// Of `time-reached` and `time-above`, in the probe's SI unit.
    #[serde(default)]
    pub threshold: Option<f64>,
    /// Of `max-slope` \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0))]
    pub window: Option<f64>,
    /// Added to every sample first, in the probe's SI unit.
    #[serde(default)]
    pub offset: f64,
    /// What comes out is multiplied by this.
    #[serde(default = "one")]
    pub scale: f64,
    /// The value of this metric, which stands before, is then taken off.
    #[serde(default)]
    pub minus: Option<String>,
    /// What is left is divided by the value of this metric, which stands before.
    #[serde(default)]
    pub over: Option<String>,
}

const fn one() -> f64 {
    1.0
}

/// What a metric must come to: `value` within `tolerance` or `absolute`, or between `min` and
/// `max`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Expected {
    /// The reference, in SI.
    pub value: Option<f64>,
    /// Greatest relative error \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0))]
    pub tolerance: Option<f64>,
    /// Greatest error, in SI.
    #[schemars(extend("minimum" = 0))]
    pub absolute: Option<f64>,
    /// Least accepted.
    pub min: Option<f64>,
    /// Greatest accepted.
    pub max: Option<f64>,
    /// Where the reference comes from.
    pub source: String,
    /// Why it is known not to hold: then it is shown as a gap, and fails nothing.
    pub gap: Option<String>,
}

/// What colours the points of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Colour {
    /// Damage \[1\].
    #[default]
    Damage,
    /// Greatest principal stress \[Pa\].
    Stress,
    /// Speed \[m/s\].
    Speed,
    /// Length of the displacement \[m\].
    Displacement,
    /// Equivalent plastic strain \[1\].
    PlasticStrain,
}
