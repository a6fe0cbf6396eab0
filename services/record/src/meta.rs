//! What a recording says about its run as a whole.

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
    /// Whether viewers get drawings of the objects, on `/scene/NAME`.
    pub drawings: bool,
    /// Leave out wall times and worker names and flush by simulated time: equal runs, equal bytes.
    pub deterministic: bool,
}

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
    map.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}
