//! Bodies at places that are given one by one, in the scene or in a table beside it.

use super::body::BodyTemplate;
use super::context::ResolveContext;
use super::direction::MIN_LENGTH;
use super::format::{GivenPlace, Instances, Rotation};
use super::generate::Instance;
use super::resolve::MAX_NAME;
use cullet_document::check::tell;
use cullet_document::files::key;
use cullet_document::tree::{Path, join};
use cullet_geometry::Vec3;
use std::collections::BTreeSet;

/// Most rows of a table of places: as many as a stack may have bodies.
pub(super) const MOST_PLACES: usize = 100_000;

/// Most faults of the places of a table that are told.
const MOST_FAULTS: usize = 20;

/// Columns of a table: the place, a turn in one of two ways, a name.
const PLACE: [&str; 3] = ["x", "y", "z"];
const QUATERNION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const ANGLES: [&str; 3] = ["rx", "ry", "rz"];
const NAME: &str = "name";

/// Places, and the lines of a table that they are from; of places in the scene there are none.
#[derive(Debug, Default)]
pub(super) struct GivenPlaces {
    pub(super) places: Vec<GivenPlace>,
    lines: Vec<usize>,
}

impl ResolveContext<'_> {
    /// The places that are written, or those of the table; what is wrong is noted.
    pub(super) fn given_places(&mut self, written: &Instances, path: &Path) -> Option<GivenPlaces> {
        let Some(file) = &written.file else {
            if written.places.is_empty() {
                if self.lacks(path, &["places", "file"]) {
                    self.wrong(path, "`places` or a `file` of them is missing");
                }
                return None;
            }
            return Some(GivenPlaces { places: written.places.clone(), lines: Vec::new() });
        };
        let below = join(path, "file");
        if !written.places.is_empty() {
            self.wrong(&below, "takes `places` or a `file` of them, not both");
            return None;
        }
        if !file.to_lowercase().ends_with(".csv") {
            self.wrong(&below, format!("\"{file}\" is no table of places: those end in .csv"));
            return None;
        }
        let key = key(&self.root.nearest(&below).text.base, file);
        if !self.has_file(&key, &below) {
            return None;
        }
        let bytes = self.files.get(&key).ok()?;
        match read(&bytes) {
            Ok(places) => Some(places),
            Err(why) => {
                self.wrong(&below, format!("{file}, {why}"));
                None
            }
        }
    }

    /// The bodies at these places.
    pub(super) fn placed(
        &mut self,
        written: &Instances,
        given: &GivenPlaces,
        template: &BodyTemplate,
        path: &Path,
    ) -> Vec<Instance> {
        let mut instances = Vec::with_capacity(given.places.len());
        let mut names = BTreeSet::new();
        let most = self.errors.len() + MOST_FAULTS;
        for (index, place) in given.places.iter().enumerate() {
            if self.errors.len() >= most {
                break;
            }
            let line = written.file.as_ref().zip(given.lines.get(index));
            let line =
                line.map_or_else(String::new, |(file, line)| format!("{file}, line {line}: "));
            let at = if written.file.is_some() {
                join(path, "file")
            } else {
                join(&join(path, "places"), index)
            };
            let own = place.name.clone().unwrap_or_else(|| index.to_string());
            let name = format!("{}-{own}", written.name);
            let sound = !own.trim().is_empty() && !own.contains('/') && name.len() <= MAX_NAME;
            if !sound {
                let message = format!(
                    "{line}\"{name}\" is no name of a body: it has 1 to {MAX_NAME} bytes and no \
                     slash"
                );
                self.wrong(&at, message);
            } else if !names.insert(name.clone()) {
                self.wrong(&at, format!("{line}a second place is called \"{own}\""));
            }
            let turn = self.rotation(&place.rotation, &join(&at, "rotation"));
            instances.push(Instance {
                name,
                position: Vec3::from(place.position),
                rotation: turn * template.placement.rotation,
                by_centroid: false,
            });
        }
        instances
    }
}

/// Where the columns of a table are.
struct PlaceColumns {
    place: [usize; 3],
    quaternion: Option<[usize; 4]>,
    angles: Option<[usize; 3]>,
    name: Option<usize>,
}

impl PlaceColumns {
    fn of(head: &csv::StringRecord) -> Result<Self, String> {
        let known = || PLACE.into_iter().chain(QUATERNION).chain(ANGLES).chain([NAME]);
        let mut seen = BTreeSet::new();
        for name in head {
            if !known().any(|known| known == name) {
                let known = known().collect::<Vec<_>>().join(", ");
                return Err(format!("there is no column \"{name}\"; known: {known}"));
            }
            if !seen.insert(name) {
                return Err(format!("a second column is called \"{name}\""));
            }
        }
        let at = |name: &str| head.iter().position(|it| it == name);
        let all = |names: &[&str]| names.iter().map(|name| at(name)).collect::<Option<Vec<_>>>();
        let any = |names: &[&str]| names.iter().any(|name| at(name).is_some());
        let group = |names: &[&str]| match (all(names), any(names)) {
            (Some(found), _) => Ok(Some(found)),
            (None, false) => Ok(None),
            (None, true) => Err(format!("it takes all of the columns {}", names.join(", "))),
        };
        let Some(place) = group(&PLACE)?.and_then(|found| found.try_into().ok()) else {
            return Err("the columns x, y, z are missing".to_owned());
        };
        let quaternion = group(&QUATERNION)?.and_then(|found| found.try_into().ok());
        let angles = group(&ANGLES)?.and_then(|found| found.try_into().ok());
        if quaternion.is_some() && angles.is_some() {
            return Err("a turn has the columns qw… or rx…, not both".to_owned());
        }
        Ok(Self { place, quaternion, angles, name: at(NAME) })
    }
}

/// The places of a table; says the line of what is wrong.
fn read(bytes: &[u8]) -> Result<GivenPlaces, String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let before = &bytes[..error.valid_up_to()];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        format!("line {line}: it is not UTF-8 text")
    })?;
    // Below the head a # is the first letter of a name.
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim_start().is_empty());
    let Some((line, head)) = lines.find(|(_, line)| !line.trim_start().starts_with('#')) else {
        return Err("line 1: the columns x, y, z are missing".to_owned());
    };
    let at = |line: usize, why: String| format!("line {line}: {why}");
    let head = values(head).map_err(|why| at(line, why))?;
    let columns = PlaceColumns::of(&head).map_err(|why| at(line, why))?;
    let mut given = GivenPlaces::default();
    for (line, row) in lines {
        if given.places.len() == MOST_PLACES {
            return Err(at(line, format!("at most {MOST_PLACES} places are taken")));
        }
        let row = values(row).map_err(|why| at(line, why))?;
        given.places.push(columns.place(&row, head.len()).map_err(|why| at(line, why))?);
        given.lines.push(line);
    }
    match given.places.is_empty() {
        true => Err(at(line, "no row follows it".to_owned())),
        false => Ok(given),
    }
}

/// The values of a line.
fn values(line: &str) -> Result<csv::StringRecord, String> {
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.has_headers(false).trim(csv::Trim::All).from_reader(line.as_bytes());
    let row = reader.into_records().next().unwrap_or_else(|| Ok(csv::StringRecord::new()));
    row.map_err(|error| error.to_string())
}

impl PlaceColumns {
    /// The place of a row, of which the head has `count` columns.
    fn place(&self, row: &csv::StringRecord, count: usize) -> Result<GivenPlace, String> {
        if row.len() != count {
            return Err(format!("it has {} values where the head has {count}", row.len()));
        }
        let number = |column: usize| {
            let text = row.get(column).unwrap_or_default();
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| {
                let text: String = text.chars().take(40).collect();
                format!("\"{text}\" in column {} is no number", column + 1)
            })
        };
        let three = |[x, y, z]: [usize; 3]| Ok::<_, String>([number(x)?, number(y)?, number(z)?]);
        let mut rotation = Rotation::default();
        if let Some([w, x, y, z]) = self.quaternion {
            let quaternion = [number(w)?, number(x)?, number(y)?, number(z)?];
            let norm = nalgebra::Vector4::from(quaternion).norm();
            if norm <= MIN_LENGTH {
                let least = tell(MIN_LENGTH);
                let norm = tell(norm);
                let text = format!("the quaternion must have a length above {least}; it is {norm}");
                return Err(text);
            }
            rotation.quaternion = Some(quaternion);
        }
        if let Some(angles) = self.angles {
            rotation.euler_degrees = Some(three(angles)?);
        }
        let name = self.name.and_then(|column| row.get(column));
        let name = name.filter(|name| !name.is_empty()).map(str::to_owned);
        Ok(GivenPlace { position: three(self.place)?, rotation, name })
    }
}
