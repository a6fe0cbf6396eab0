//! What a recording says about its run as a whole.

use super::palette::Rgb;
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// Where the scene wants to be looked at from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye \[m\].
    pub eye: Vec3,
    /// What it looks at \[m\].
    pub target: Vec3,
    /// Vertical field of view \[degrees\].
    pub fov: f64,
    /// When the preview starts \[s\].
    pub start: Option<f64>,
    /// When it ends \[s\].
    pub end: Option<f64>,
}

/// What the material inside an object looks like, on its crack faces, where the scene says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InteriorLook {
    /// Colour on a screen (sRGB), each part in \[0, 1\] \[1\].
    pub colour: Rgb,
    /// Roughness as renderers take it, 0 for a mirror and 1 for chalk \[1\].
    pub roughness: f32,
}

/// What a recording says about its run as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct RunMeta {
    /// Name of the scene.
    pub scene: String,
    /// Its seed.
    pub seed: u64,
    /// Version of the program.
    pub version: String,
    /// The scene file as it was run, overrides applied.
    pub scene_text: String,
    /// Files that the scene needs, name and content.
    pub files: Vec<(String, Vec<u8>)>,
    /// Time step \[s\].
    pub step: f64,
    /// Planned simulated time \[s\].
    pub duration: f64,
    /// Gravity \[m/s²\]; up is against it, or z where there is none.
    pub gravity: Vec3,
    /// Each material of the scene, name and description.
    pub materials: BTreeMap<String, String>,
    /// Where to look from.
    pub view: Option<View>,
    /// What objects look like inside, by name, where the scene says so.
    pub interiors: BTreeMap<String, InteriorLook>,
    /// Bodies whose strength the scene painted.
    pub painted: u64,
    /// Whether viewers get drawings of the objects, on `/scene/NAME`.
    pub drawings: bool,
    /// Leave out wall times and worker names and flush by simulated time: equal runs, equal bytes.
    pub deterministic: bool,
}

/// What the keys of [`InteriorLook`] begin with, before the name of the object.
const INTERIOR: &str = "interior.";

/// Against gravity, or z.
pub(super) fn up(gravity: Vec3) -> Vec3 {
    (-gravity).try_normalize(1e-12).unwrap_or_else(Vec3::z)
}

fn list(v: Vec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

pub(super) fn meta_map(meta: &RunMeta) -> BTreeMap<String, String> {
    let mut map = BTreeMap::from([
        ("scene", meta.scene.clone()),
        ("seed", meta.seed.to_string()),
        ("version", meta.version.clone()),
        ("schema_version", super::SCHEMA_VERSION.to_string()),
        ("step", meta.step.to_string()),
        ("duration", meta.duration.to_string()),
        ("gravity", list(meta.gravity)),
        ("deterministic", meta.deterministic.to_string()),
    ]);
    if let Some(view) = meta.view {
        map.insert("view.eye", list(view.eye));
        map.insert("view.target", list(view.target));
        map.insert("view.fov", view.fov.to_string());
        for (key, time) in [("view.start", view.start), ("view.end", view.end)] {
            if let Some(time) = time {
                map.insert(key, time.to_string());
            }
        }
    }
    if meta.painted > 0 {
        map.insert("painted", meta.painted.to_string());
    }
    let interior = |(object, look): (&String, &InteriorLook)| {
        let InteriorLook { colour: [r, g, b], roughness } = look;
        (format!("{INTERIOR}{object}"), format!("{r} {g} {b} {roughness}"))
    };
    let interiors = meta.interiors.iter().map(interior);
    map.into_iter().map(|(key, value)| (key.to_owned(), value)).chain(interiors).collect()
}

/// What objects look like inside, by name, where the metadata of a run says so.
pub(super) fn interiors(meta: &BTreeMap<String, String>) -> BTreeMap<String, InteriorLook> {
    let objects = meta.keys().filter_map(|key| key.strip_prefix(INTERIOR));
    objects.filter_map(|object| Some((object.to_owned(), interior_of(meta, object)?))).collect()
}

/// What an object looks like inside, likewise.
pub(super) fn interior_of(meta: &BTreeMap<String, String>, object: &str) -> Option<InteriorLook> {
    let text = meta.get(&format!("{INTERIOR}{object}"))?;
    let numbers: Vec<f32> = text.split(' ').filter_map(|part| part.parse().ok()).collect();
    let &[r, g, b, roughness] = &numbers[..] else { return None };
    let sound = numbers.iter().all(|number| (0.0..=1.0).contains(number));
    sound.then_some(InteriorLook { colour: [r, g, b], roughness })
}
