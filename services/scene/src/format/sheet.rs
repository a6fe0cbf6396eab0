//! A thin sheet as it is written: what it is, what holds it, what it takes up.

use super::rotation::Rotation;
use cullet_document::tree::{Path, join};
use cullet_document::unit;
use cullet_model::membrane::MOST_QUANTITIES;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// How the bonds of a sheet stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SheetLaw {
    /// Elastic until they soften and tear: paper, dry leaves.
    Brittle,
    /// They flow at `yield_stress` and then tear: metal foil.
    Foil,
    /// Elastic to large stretches, then they tear: rubber.
    Rubber,
}

/// Whether rigid bodies feel a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Coupling {
    /// Bodies and sheet push each other.
    #[default]
    TwoWay,
    /// Bodies push the sheet and go their way; what they did not get is recorded.
    OneWay,
}

/// How fast waves run in a sheet: real speeds cost some 1e6 steps a second. Either `softer` or
/// `heavier`; with neither the speed is real. What was chosen is recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WavePace {
    /// The sheet is made softer, so that waves run at this speed \[m/s\]; its weight, fracture
    /// energy and bending stay. For sheets that fly and drape.
    #[schemars(
        schema_with = "unit::velocity",
        extend("exclusiveMinimum" = 0, "maximum" = 1e5, "x-default" = "none")
    )]
    pub softer: Option<f64>,
    /// The sheet is made more inert, so that waves run at this speed \[m/s\]; its stiffness and
    /// weight stay. For sheets that are held and torn slowly.
    #[schemars(
        schema_with = "unit::velocity",
        extend("exclusiveMinimum" = 0, "maximum" = 1e5, "x-default" = "none")
    )]
    pub heavier: Option<f64>,
}

/// Part of a sheet, in its own plane: either a box from `low` to `high`, or a disc of `radius`
/// around `centre`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SheetPatch {
    /// Least coordinates of a box \[m\].
    #[schemars(schema_with = "unit::length2", extend("x-default" = "none, but required for a box"))]
    pub low: Option<[f64; 2]>,
    /// Greatest coordinates of a box \[m\].
    #[schemars(schema_with = "unit::length2", extend("x-default" = "none, but required for a box"))]
    pub high: Option<[f64; 2]>,
    /// Centre of a disc \[m\].
    #[schemars(
        schema_with = "unit::length2",
        extend("x-default" = "none, but required for a disc")
    )]
    pub centre: Option<[f64; 2]>,
    /// Radius of a disc \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "none, but required for a disc")
    )]
    pub radius: Option<f64>,
}

/// Where a grip is at a time.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GripPlace {
    /// When the grip is there \[s\].
    #[schemars(schema_with = "unit::time", extend("minimum" = 0, "maximum" = 600))]
    pub time: f64,
    /// How far it then is from where it began \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub offset: [f64; 3],
}

/// Something that holds part of a sheet: it stays, or moves at `velocity` or along `path`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grip {
    /// The part of the sheet that it holds.
    pub patch: SheetPatch,
    /// How fast it moves \[m/s\]. Not beside `path`.
    #[serde(default)]
    #[schemars(schema_with = "unit::velocity3", extend("x-default" = "it stays"))]
    pub velocity: Option<[f64; 3]>,
    /// Where it is at rising times; straight lines lie between them, and it stays at the last. Not
    /// beside `velocity`.
    #[serde(default)]
    #[schemars(length(max = 1024), extend("x-default" = "it stays"))]
    pub path: Vec<GripPlace>,
    /// When it lets go \[s\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::time",
        extend("minimum" = 0, "maximum" = 600, "x-default" = "never")
    )]
    pub until: Option<f64>,
}

/// The air around a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Density of the air \[kg/m³\].
    #[schemars(schema_with = "unit::density", extend("minimum" = 0, "maximum" = 2000))]
    pub density: f64,
    /// Its drag on the area that faces it, over that of its dynamic pressure \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 10))]
    pub drag: f64,
    /// How fast it moves \[m/s\].
    #[schemars(schema_with = "unit::velocity3")]
    pub wind: [f64; 3],
    /// How much stronger gusts are than the wind, at most \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 10))]
    pub gusts: f64,
    /// How often gusts come \[1/s\].
    #[schemars(schema_with = "unit::rate", extend("minimum" = 0, "maximum" = 100))]
    pub gust_rate: f64,
    /// Pressure on the lower side over that on the upper side \[Pa\].
    #[schemars(schema_with = "unit::pressure")]
    pub pressure: f64,
}

impl Default for Air {
    fn default() -> Self {
        Self { density: 1.2, drag: 1.2, wind: [0.0; 3], gusts: 0.0, gust_rate: 1.0, pressure: 0.0 }
    }
}

/// Where something comes into a sheet: one of `value`, `flux` and `film`. It comes into a `patch`
/// or, through a `film`, from a `body` where that touches the sheet.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SheetInflow {
    /// The part of the sheet that it comes into.
    #[serde(default)]
    #[schemars(extend("x-default" = "required without `body`; beside it the whole sheet"))]
    pub patch: Option<SheetPatch>,
    /// Name of a rigid body that it comes from, such as a hot iron: where and while that body, or a
    /// fragment of it, touches the sheet, the quantity passes through `film`. The body keeps
    /// `towards`, whatever it gives. Of a grid and its like one body is named: `bricks-0`.
    #[serde(default)]
    #[schemars(extend("x-default" = "none"))]
    pub body: Option<String>,
    /// From when it comes \[s\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::time",
        extend("minimum" = 0, "maximum" = 600, "x-default" = "0 s")
    )]
    pub from: Option<f64>,
    /// Until when it comes \[s\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::time",
        extend("minimum" = 0, "maximum" = 600, "x-default" = "the end of the run")
    )]
    pub until: Option<f64>,
    /// The quantity is held at this value there \[1\].
    #[serde(default)]
    #[schemars(extend("x-default" = "none"))]
    pub value: Option<f64>,
    /// What comes in by area and time, in units of the quantity times `capacity` \[1\].
    #[serde(default)]
    #[schemars(extend("x-default" = "none"))]
    pub flux: Option<f64>,
    /// What comes in by area, time and difference to `towards`, in units of `capacity` \[1\].
    #[serde(default)]
    #[schemars(extend("x-default" = "none"))]
    pub film: Option<f64>,
    /// The quantity on the other side of a `film` \[1\].
    #[serde(default)]
    #[schemars(extend("x-default" = "none, but required beside `film`"))]
    pub towards: Option<f64>,
}

/// A quantity that spreads in a sheet, such as water by dry mass or temperature in K, and what it
/// does to it. Tables are rows of the quantity and the share that is left of it there; straight
/// lines lie between them. One quantity is a table, `[sheet.diffusion]`; up to four are a list of
/// them, `[[sheet.diffusion]]`, each with its own `name`. None acts on another. Shares that several
/// leave multiply; strains and masses add.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Diffusion {
    /// Name of the quantity in messages and figures: 1 to 40 bytes, and unique in the sheet.
    #[schemars(extend("x-default" = "`quantity`, but required in a list of several"))]
    pub name: Option<String>,
    /// Whether frames of the recording and pictures show it; of several, one is shown.
    #[schemars(extend("x-default" = "`true` of the first, if no other has it"))]
    pub show: Option<bool>,
    /// What a volume takes up for the quantity to grow by 1, by the quantity's own
    /// unit \[1\].
    #[schemars(range(min = 1e-9, max = 1e12))]
    pub capacity: f64,
    /// How well it spreads along the sheet's x and y axes, over `capacity`, in m²/s \[1\].
    #[schemars(extend("x-default" = "[1e-6, 1e-6]"))]
    pub diffusivity: [f64; 2],
    /// Strain by the quantity along the sheet's x and y axes \[1\].
    pub expansion: [f64; 2],
    /// The quantity before anything happens \[1\].
    pub start: f64,
    /// The quantity at which the sheet takes up no more \[1\].
    #[schemars(extend("x-default" = "no bound"))]
    pub saturation: Option<f64>,
    /// Rows of the quantity and the share of Young's modulus that is left \[1\].
    #[schemars(length(max = 64), extend("x-default" = "all of it, at any"))]
    pub stiffness: Vec<[f64; 2]>,
    /// Rows of the quantity and the share of the fracture energy that is left \[1\].
    #[schemars(length(max = 64), extend("x-default" = "all of it, at any"))]
    pub toughness: Vec<[f64; 2]>,
    /// Rows of the quantity and the share of the strength that is left \[1\].
    #[schemars(length(max = 64), extend("x-default" = "all of it, at any"))]
    pub strength: Vec<[f64; 2]>,
    /// Rate at which the quantity eats away at the fracture energy for good \[1/s\].
    #[schemars(schema_with = "unit::rate", extend("minimum" = 0, "maximum" = 1e6))]
    pub exposure: f64,
    /// Mass by volume that the sheet gains as the quantity grows by 1 \[kg/m³\].
    #[schemars(schema_with = "unit::density", extend("minimum" = 0, "maximum" = 30000))]
    pub weight: f64,
    /// What goes to the air by area, time and difference to `ambient` \[m/s\], in units of
    /// `capacity`.
    #[schemars(schema_with = "unit::velocity", extend("minimum" = 0))]
    pub loss: f64,
    /// The quantity of the air \[1\].
    pub ambient: f64,
    /// Where something comes in.
    #[schemars(length(max = 256))]
    pub source: Vec<SheetInflow>,
}

impl Default for Diffusion {
    fn default() -> Self {
        Self {
            name: None,
            show: None,
            capacity: 1.0,
            diffusivity: [1e-6; 2],
            expansion: [0.0; 2],
            start: 0.0,
            saturation: None,
            stiffness: Vec::new(),
            toughness: Vec::new(),
            strength: Vec::new(),
            exposure: 0.0,
            weight: 0.0,
            loss: 0.0,
            ambient: 0.0,
            source: Vec::new(),
        }
    }
}

/// The quantities that spread in a sheet, as they are written.
#[derive(Clone, Debug, PartialEq)]
pub enum Diffusions {
    /// A table.
    One(Box<Diffusion>),
    /// A list of tables.
    Some(Vec<Diffusion>),
}

impl Diffusions {
    /// Each with the steps of its path below the sheet.
    pub fn each(&self) -> Vec<(Path, &Diffusion)> {
        let path: Path = vec!["diffusion".into()];
        match self {
            Self::One(one) => vec![(path, &**one)],
            Self::Some(all) => {
                all.iter().enumerate().map(|(k, one)| (join(&path, k), one)).collect()
            }
        }
    }
}

impl<'de> Deserialize<'de> for Diffusions {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrSome;
        impl<'de> Visitor<'de> for OneOrSome {
            type Value = Diffusions;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table or a list of tables")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Diffusions, A::Error> {
                let one = Diffusion::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Diffusions::One(Box::new(one)))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, all: A) -> Result<Diffusions, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(all)).map(Diffusions::Some)
            }
        }
        deserializer.deserialize_any(OneOrSome)
    }
}

fn one_or_some(generator: &mut SchemaGenerator) -> Schema {
    let one = generator.subschema_for::<Diffusion>();
    let list =
        json_schema!({ "type": "array", "items": one, "minItems": 1, "maxItems": MOST_QUANTITIES });
    json_schema!({ "anyOf": [list, one] })
}

/// A thin sheet that moves, tears, wrinkles, dries and soaks for as long as the run lasts. It lies
/// in the plane of its own x and y axes. Either `size` or `outline`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SheetBody {
    /// Name of the sheet in messages and recordings: 1 to 80 bytes, without a slash, and unique in
    /// the scene.
    #[schemars(extend("x-default" = "required"))]
    pub name: Option<String>,
    /// Width and height of a rectangle around the sheet's origin \[m\].
    #[schemars(
        schema_with = "unit::length2",
        extend("x-default" = "none, but required without `outline`")
    )]
    pub size: Option<[f64; 2]>,
    /// Corners of its outline, in order, in its own plane \[m\].
    #[schemars(
        schema_with = "unit::points2",
        extend("x-default" = "none, but required without `size`")
    )]
    pub outline: Option<Vec<[f64; 2]>>,
    /// Lines along which it is cut at the start, each by its corners \[m\].
    #[schemars(schema_with = "unit::lines2", extend("x-default" = "none"))]
    pub notches: Vec<Vec<[f64; 2]>>,
    /// Thickness of the sheet \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "required")
    )]
    pub thickness: Option<f64>,
    /// Distance of the points that it is simulated by \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "1/50 of the longer side of its box")
    )]
    pub spacing: Option<f64>,
    /// Name of a preset or of a `[[material]]`.
    #[schemars(extend("x-default" = "required"))]
    pub material: Option<String>,
    /// How its bonds stretch.
    #[schemars(extend("x-default" = "`foil` if the material yields, else `brittle`"))]
    pub law: Option<SheetLaw>,
    /// Standard deviation of its strength from place to place, over the mean \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.5))]
    pub scatter: f64,
    /// Least thickness by which it bends, over `spacing` \[1\]: lower shows finer wrinkles.
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 2, "x-default" = "0.3")
    )]
    pub bending_floor: Option<f64>,
    /// Share of critical damping that its fastest motion has \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = "0.1")
    )]
    pub damping: Option<f64>,
    /// Where the sheet's origin is \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// Rotation about its origin; without one the sheet lies flat.
    pub rotation: Rotation,
    /// Velocity of the whole sheet at the start \[m/s\].
    #[schemars(schema_with = "unit::velocity3")]
    pub velocity: [f64; 3],
    /// What holds it.
    #[schemars(length(max = 256))]
    pub grip: Vec<Grip>,
    /// The air around it.
    pub air: Air,
    /// A quantity that spreads in it, or a list of up to four of them.
    #[schemars(schema_with = "one_or_some", extend("x-default" = "none"))]
    pub diffusion: Option<Diffusions>,
    /// Stiffness by area, in Pa/m, of a base that it clings to: each point is pulled back to where
    /// it is at rest, as mud is by what lies under it \[1\].
    #[schemars(range(min = 0, max = 1e12), extend("x-default" = "none"))]
    pub foundation: Option<f64>,
    /// How fast waves run in it.
    pub pace: WavePace,
    /// Steps of the rigid world that are simulated at once \[1\].
    #[schemars(range(min = 1, max = 256), extend("x-default" = "4"))]
    pub window: Option<u32>,
    /// Whether rigid bodies feel it.
    pub coupling: Coupling,
    /// Whether pieces of it that come to rest become rigid bodies of their shape, which deform no
    /// more.
    pub retire: bool,
}
