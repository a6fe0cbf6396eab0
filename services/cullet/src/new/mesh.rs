//! A scene of a mesh file: it falls onto a floor, at the size that it has.

use super::draft::NewScene;
use crate::exit::{CommandError, Exit};
use crate::shown::shown;
use cullet_document::SceneError;
use cullet_document::files::SCENE_BASE;
use cullet_files::regular;
use cullet_geometry::TriMesh;
use cullet_scene::{SCENE_FILE, Scene};
use std::path::Path;

/// The scene, with names in braces for what depends on the mesh.
const TEMPLATE: &str = include_str!("mesh.toml");

/// Most bytes of the name of a body.
const MOST_BYTES: usize = 80;
/// From how far it falls \[m\]: as far as the pot among the shipped scenes.
const HEIGHT: f64 = 2.0;
/// Standard gravity, as scenes have it \[m/s²\].
const GRAVITY: f64 = 9.81;
/// How far it is turned, so that it lands on an edge and not flat \[degrees\].
const TILT: f64 = 20.0;
/// What is above the floor at the start, as a share of the longest side.
const GAP: f64 = 0.1;
/// Lengths that a thing has which is broken \[m\]; what is beyond them is in another unit.
const SHORTEST: f64 = 0.005;
const LONGEST: f64 = 20.0;
/// Metres in a millimetre, which many programs write.
const MILLIMETRE: f64 = 1e-3;
/// How long it is made where neither unit is plausible \[m\].
const USUAL: f64 = 0.2;
/// The floor, the eye and the target in lengths of it; fragments fly some lengths.
const FLOOR: f64 = 12.0;
const EYE: [f64; 3] = [1.9, -2.5, 1.6];
/// The least side of the floor, and its height \[m\].
const FLOOR_SIDE: f64 = 6.0;
const FLOOR_HEIGHT: f64 = 0.2;

/// Makes the scene and checks it as any other; nothing is written.
pub(super) fn make_scene(path: &Path, folder: &str) -> Result<NewScene, CommandError> {
    let wrong = |text: String| {
        let text = format!("{}: {text}", path.display());
        CommandError::new(Exit::Usage, text).at(path.display())
    };
    let bytes = regular::read(path).map_err(|error| CommandError::file(path, error))?;
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mesh = cullet_assets::read(&file, &bytes).map_err(|error| wrong(error.to_string()))?;
    let size = MeshSize::of(&mesh, &file);
    let mut name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    name.truncate(name.floor_char_boundary(MOST_BYTES));
    let text = write_text(&file, &name, &size);
    let beside = path.parent().unwrap_or(Path::new(""));
    let scene = Scene::assemble(&name, &text, Vec::new(), Some(beside), &[])
        .map_err(|found| wrong(tell_errors(&found.errors)))?;
    let mut about = vec![about_body(&scene, &name, &size, folder)];
    about.extend(size.unit().map(|unit| format!("{file}: {unit}")));
    about.extend(scene.warnings.iter().map(|line| format!("warning: {line}")));
    // What it names, such as materials and pictures, as far as it lies beside it.
    let named = scene.files.into_iter().filter_map(|file| {
        let name = file.key.strip_prefix(SCENE_BASE).filter(|name| !name.contains('/'))?;
        Some((name.to_owned(), file.bytes.to_vec()))
    });
    Ok(NewScene { about, files: named.collect() })
}

/// What is wrong with a scene whose text nobody has seen.
fn tell_errors(errors: &[SceneError]) -> String {
    let tell = |error: &SceneError| match &error.help {
        Some(help) => format!("{}\n  help: {help}", error.message),
        None => error.message.clone(),
    };
    errors.iter().map(tell).collect::<Vec<_>>().join("\n")
}

fn about_body(scene: &Scene, name: &str, size: &MeshSize, folder: &str) -> String {
    let [across, deep, high] = size.sides.map(|side| short(side * size.scale));
    let body = scene.bodies.iter().find(|body| body.name == name);
    let mass = body.map_or(0.0, |body| body.volume * body.material.density);
    format!(
        "{folder}/{SCENE_FILE} is a scene: {} falls as from {HEIGHT} m; {across} x {deep} x {high} \
         m, {} kg of plaster",
        shown(name),
        short(mass)
    )
}

/// How large a mesh is.
struct MeshSize {
    /// Its sides in the file's unit: across, deep, high.
    sides: [f64; 3],
    /// The axis of the file that points up.
    up: &'static str,
    /// Metres in the file's unit.
    scale: f64,
}

impl MeshSize {
    fn of(mesh: &TriMesh, file: &str) -> Self {
        // Programs for printing in three dimensions have z up, most others have y.
        let up = if file.to_lowercase().ends_with(".stl") { "z" } else { "y" };
        let side = |axis: usize| {
            let along = || mesh.vertices.iter().map(|vertex| vertex[axis]);
            along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
        };
        let sides =
            if up == "z" { [side(0), side(1), side(2)] } else { [side(0), side(2), side(1)] };
        let longest = sides.into_iter().fold(0.0, f64::max);
        let fits = |scale: &f64| (SHORTEST..=LONGEST).contains(&(longest * scale));
        let scale = [1.0, MILLIMETRE].into_iter().find(fits);
        Self { sides, up, scale: scale.unwrap_or_else(|| round(USUAL / longest)) }
    }

    /// Its longest side \[m\].
    fn longest(&self) -> f64 {
        self.scale * self.sides.into_iter().fold(0.0, f64::max)
    }

    /// What its unit is taken for, unless it is in metres.
    fn unit(&self) -> Option<String> {
        let longest = short(self.longest() / self.scale);
        let taken = match self.scale {
            1.0 => return None,
            MILLIMETRE => "it is taken to be in millimetres",
            _ => "it is scaled",
        };
        let (scale, length) = (self.scale, short(self.longest()));
        Some(format!(
            "in metres it would be {longest} m long; {taken}: scale = {scale}, {length} m"
        ))
    }

    /// The line of its scale.
    fn scale_line(&self) -> String {
        match self.unit() {
            Some(unit) => format!("scale = {} # {unit}", self.scale),
            None => {
                let longest = short(self.longest());
                format!(
                    "# fit = \"20 cm\"              # the longest side, in place of {longest} m"
                )
            }
        }
    }
}

/// The text of the scene.
fn write_text(file: &str, name: &str, size: &MeshSize) -> String {
    let longest = size.longest();
    let deep = size.sides[1] * size.scale;
    let high = size.sides[2] * size.scale;
    // The lowest corner of its box, turned about the middle of its base.
    let lift = 0.5 * deep * TILT.to_radians().sin() + GAP * longest;
    let floor_height = FLOOR_HEIGHT.max(0.1 * longest);
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let eye = EYE.map(|at| short(at * longest)).join(", ");
    let floor = if name == "floor" { "ground" } else { "floor" };
    let values = [
        ("{file}", shown(file).into_owned()),
        ("{description}", quoted(&format!("{name} falls onto a stone floor."))),
        ("{floor}", quoted(floor)),
        ("{floor_side}", short(FLOOR_SIDE.max(FLOOR * longest))),
        ("{floor_height}", short(floor_height)),
        ("{floor_middle}", format!("-{}", short(0.5 * floor_height))),
        ("{name}", quoted(name)),
        ("{file_text}", quoted(file)),
        ("{up}", size.up.to_owned()),
        ("{scale}", size.scale_line()),
        ("{lift}", short(lift)),
        ("{tilt}", short(TILT)),
        ("{speed}", short((2.0 * GRAVITY * HEIGHT).sqrt())),
        ("{height}", short(HEIGHT)),
        ("{eye}", eye),
        ("{target}", short(0.4 * high)),
    ];
    values.iter().fold(TEMPLATE.to_owned(), |text, (key, value)| text.replace(key, value))
}

/// A number of three digits.
fn round(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// The same as a person writes it.
fn short(value: f64) -> String {
    round(value).to_string()
}
