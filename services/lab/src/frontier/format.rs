//! The standing set as it is written: the one source of its reader and of its schema.

use schemars::JsonSchema;
use serde::Deserialize;

/// A standing set: charts of error over cost, each of one specimen or scene.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FrontierDocument {
    /// What the set is for, in a line.
    pub description: String,
    /// Files read before this one, relative to it. This file's values win.
    #[schemars(length(max = 64))]
    pub include: Vec<String>,
    /// Its charts.
    #[schemars(length(min = 1, max = 64))]
    pub chart: Vec<ChartForm>,
}

/// A chart: one number of one specimen or scene, solved with several options.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChartForm {
    /// Its name, and that of its files: letters, digits, `-` and `_`.
    pub name: String,
    /// What it shows, in a line; else its name.
    #[serde(default)]
    pub title: String,
    /// A specimen file, relative to this file. Either this or `scene`.
    pub specimen: Option<String>,
    /// A scene file or its folder, relative to this file. What is charted is how far the masses of
    /// its fragments are from those of the run `finest`.
    pub scene: Option<String>,
    /// Which metric of the specimen; of a scene "mass distance", as it is without one, "KS of
    /// Mott's law", "share of pieces sampled" or "share of mass sampled".
    pub metric: Option<String>,
    /// What it must come to; else the value that the specimen expects.
    pub reference: Option<f64>,
    /// Where that comes from; else what the specimen says.
    pub source: Option<String>,
    /// What errors are divided by; else the size of the reference.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: Option<f64>,
    /// Whose fragments of the scene; else those of everything that breaks.
    pub object: Option<String>,
    /// Overrides of the run of the scene that the others are held against; without any it is the
    /// scene as its file has it, and the default.
    #[serde(default)]
    #[schemars(length(max = 64))]
    pub finest: Vec<String>,
    /// Overrides of every run, `path=value` each, as `--set` takes them.
    #[serde(default)]
    #[schemars(length(max = 64))]
    pub set: Vec<String>,
    /// What changes along a curve, the coarsest first, as `--sweep` takes it: `spacing=4mm,2mm`. Of
    /// a scene `points=1,2,4` is so many times its `fracture.max_particles`.
    pub along: String,
    /// The value along the first option's curve that is the default; else where that is the
    /// specimen as its file has it.
    pub default: Option<String>,
    /// Seeds of each point: 1, or at least 8 where the outcome is chaotic.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 64))]
    pub seeds: u32,
    /// The curves; the first is the default. Without any there is one.
    #[serde(default)]
    #[schemars(length(max = 12))]
    pub option: Vec<OptionForm>,
}

/// A curve: what is set otherwise than in the chart.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OptionForm {
    /// What the chart calls it.
    pub name: String,
    /// Overrides over those of the chart.
    #[serde(default)]
    #[schemars(length(max = 64))]
    pub set: Vec<String>,
    /// What changes along this curve, in place of the chart's.
    pub along: Option<String>,
    /// In a chart of what is sampled, which of its two shares this curve shows; else the chart's.
    pub metric: Option<String>,
}

const fn one() -> u32 {
    1
}
