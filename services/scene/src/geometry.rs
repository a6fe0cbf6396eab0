//! A body's geometry: its solid about its own centroid and what stands in for it in collisions.
//!
//! A geometry is made once for all bodies that share it: 200 bricks cost one mesh and one hull.

use super::format::{Axis, RepairChoice, Shape};
use super::parts::{self, PartsMesh, PlacedShape};
use super::shape;
use cullet_assets::MeshFile;
use cullet_document::check::tell;
use cullet_document::error::nearest;
use cullet_document::files::{FileError, Files, folder_of, key};
use cullet_geometry::attributes::SurfaceAttributes;
use cullet_geometry::door::{self, Repair, RepairReport};
use cullet_geometry::hull::{self, HullSettings};
use cullet_geometry::midsurface::thicken;
use cullet_geometry::{MassProperties, Solid, TriMesh, Vec3};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Longest side of a body \[m\]: larger ones are a mistaken unit.
pub(super) const MAX_SIZE: f64 = 1e4;

/// Shortest longest side of a body \[m\]: smaller ones are a mistaken unit.
pub(super) const MIN_SIZE: f64 = 1e-4;

/// A centroid within this share of the longest side of the origin is at it \[1\].
const CENTRED: f64 = 1e-11;

/// Whole bodies are few and seen from near: more parts than fragments get, so that vessels stay
/// hollow.
const HULLS: HullSettings =
    HullSettings { max_parts: 32, max_vertices: 32, slack: 1.2, shrink: 0.0 };

/// Names of objects that an error lists; the others are counted.
const MOST_NAMES: usize = 20;

/// Most triangles of all shapes of a scene together, bodies of equal shape counted once: what a
/// scene may make a coordinator hold is bounded before any of it is simulated.
const MOST_TRIANGLES: usize = 16_000_000;

/// Ends of the names of pictures that a mesh file may name.
const PICTURES: [&str; 3] = ["png", "jpg", "jpeg"];

/// Larger pictures are not recorded: a texture of 8192 by 8192 pixels as PNG is about this.
const MOST_PICTURE_BYTES: u64 = 64 << 20;

/// What a geometry is made from.
#[derive(Clone, Debug)]
pub enum GeometrySource {
    /// By measures.
    Shape(Shape),
    /// Shapes that together are one body.
    Parts(Vec<PlacedShape>),
    /// From a file.
    Mesh {
        /// Its key.
        key: String,
        /// Longest side \[m\].
        fit: Option<f64>,
        /// Factor \[1\].
        scale: Option<f64>,
        /// Thickness of the wall that the surface is the middle of; without it, it bounds a solid
        /// \[m\].
        thickness: Option<f64>,
        /// The file's axis that points up.
        up: Option<Axis>,
        /// What happens to faults.
        repair: RepairChoice,
        /// Which of the file's objects; all without it.
        object: Option<ObjectSource>,
    },
}

/// One of the objects of a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSource {
    /// Its name.
    pub name: String,
    /// Whether its size is set by that of all objects of the file together.
    pub in_scale: bool,
}

/// A solid about its centroid, and what goes with it.
#[derive(Clone, Debug)]
pub struct BodyGeometry {
    /// The solid; its centroid is the origin \[m\].
    pub solid: Arc<Solid>,
    /// Convex parts for collisions, in the same frame \[m\].
    pub(super) hulls: Arc<Vec<Vec<Vec3>>>,
    /// At unit density; the centroid is zero.
    pub(super) mass: MassProperties,
    /// Where the origin of the shape or file is in this frame \[m\].
    pub origin: Vec3,
    /// Corners of the box around the solid, in this frame \[m\].
    pub(super) bounds: (Vec3, Vec3),
    /// What was repaired, a line each.
    pub(super) repairs: Vec<String>,
    /// The axis of the mesh file that became z, and what the file was scaled by \[1\].
    pub(super) placement: (Axis, f64),
    /// What the mesh file has beside the shape, in this frame; nothing where it has no more.
    pub(super) surface: Option<Arc<SurfaceAttributes>>,
    /// The key of the mesh file.
    pub(super) file: Option<String>,
}

impl BodyGeometry {
    /// A point of the mesh file in the frame that the scene speaks of \[m\].
    pub(super) fn placed(&self, point: &Vec3) -> Vec3 {
        let (up, factor) = self.placement;
        upright(point, up) * factor
    }

    /// Greatest distance of a corner from the centroid \[m\].
    pub(super) fn radius(&self) -> f64 {
        self.solid.mesh.vertices.iter().map(Vec3::norm).fold(0.0, f64::max)
    }
}

/// GeometryCache already made.
#[derive(Default)]
pub struct GeometryCache {
    made: BTreeMap<String, Result<Arc<BodyGeometry>, String>>,
    /// Mesh files as they are, by key.
    read: BTreeMap<String, Result<Arc<MeshFile>, String>>,
    triangles: usize,
}

impl GeometryCache {
    /// The geometry of a source; the second call for an equal source costs nothing.
    pub fn get(
        &mut self,
        source: &GeometrySource,
        files: &mut Files,
    ) -> Result<Arc<BodyGeometry>, String> {
        // The derived text of a source has every number in full, so it is as good as the source.
        let key = format!("{source:?}");
        if let Some(geometry) = self.made.get(&key) {
            return geometry.clone();
        }
        if files.is_stopped() {
            return Err(FileError::Stopped.to_string());
        }
        let made = catch_unwind(AssertUnwindSafe(|| self.make(source, files)))
            .unwrap_or_else(|_| Err("the form could not be made of these numbers".to_owned()))
            .and_then(|geometry| self.admit(geometry));
        self.made.insert(key, made.clone());
        made
    }

    fn admit(&mut self, geometry: BodyGeometry) -> Result<Arc<BodyGeometry>, String> {
        let count = self.triangles + geometry.solid.mesh.triangles.len();
        if count > MOST_TRIANGLES {
            return Err(full(count));
        }
        self.triangles = count;
        Ok(Arc::new(geometry))
    }

    /// The mesh file under a key as it is; the second call for a key costs nothing.
    fn file(&mut self, name: &str, files: &mut Files) -> Result<Arc<MeshFile>, String> {
        if let Some(read) = self.read.get(name) {
            return read.clone();
        }
        let bytes = files.get(name).map_err(|error| error.to_string())?;
        let read = cullet_assets::read_surface(name, &bytes, &mut |other: &str| {
            file_beside(files, name, other)
        });
        if let Ok(file) = &read {
            take_pictures(&file.surface, name, files);
        }
        let read = read.map(Arc::new).map_err(|error| error.to_string());
        self.read.insert(name.to_owned(), read.clone());
        read
    }

    /// Names of the objects of a mesh file that have triangles, in its order.
    pub(super) fn objects(&mut self, name: &str, files: &mut Files) -> Result<Vec<String>, String> {
        let file = self.file(name, files)?;
        let surface = &file.surface;
        let mut used = vec![false; surface.object_names.len()];
        surface.objects.iter().for_each(|&object| used[object as usize] = true);
        let names = surface.object_names.iter().zip(used);
        Ok(names.filter(|(_, used)| *used).map(|(name, _)| name.clone()).collect())
    }

    fn make(&mut self, source: &GeometrySource, files: &mut Files) -> Result<BodyGeometry, String> {
        let (name, [fit, scale, thickness], up, repair, object) = match source {
            GeometrySource::Shape(shape) => {
                let mesh = shape::mesh(shape)?;
                return finish(mesh, shape::convex(shape), Vec::new());
            }
            GeometrySource::Parts(shapes) => {
                let PartsMesh { mesh, hulls } = parts::mesh(shapes, HULLS)?;
                let geometry = finish(mesh, true, Vec::new())?;
                let moved = |hull: Vec<Vec3>| hull.iter().map(|v| v + geometry.origin).collect();
                let hulls = Arc::new(hulls.into_iter().map(moved).collect());
                return Ok(BodyGeometry { hulls, ..geometry });
            }
            GeometrySource::Mesh { key, fit, scale, thickness, up, repair, object } => {
                (key, [*fit, *scale, *thickness], *up, repair, object)
            }
        };
        let file = self.file(name, files)?;
        let whole = &file.surface;
        let mut surface = match object {
            None => whole.clone(),
            Some(object) => whole.only(named(whole, name, &object.name)?),
        };
        let default = if cullet_assets::is_gltf(name) { Axis::Y } else { Axis::Z };
        let up = up.unwrap_or(default);
        surface.turn(|v| upright(v, up));
        let in_scale = object.as_ref().is_some_and(|object| object.in_scale);
        let factor = factor(if in_scale { &whole.mesh } else { &surface.mesh }, fit, scale)?;
        surface.mesh.vertices.iter_mut().for_each(|v| *v *= factor);
        let away = away(&surface.mesh);
        surface.mesh.vertices.iter_mut().for_each(|v| *v -= away);
        let repair = match repair {
            RepairChoice::Auto => Repair::Auto,
            RepairChoice::Remesh => Repair::Remesh,
            RepairChoice::Refuse => Repair::Refuse,
        };
        if let Some(thickness) = thickness {
            let (mesh, mut repairs) = walled(&surface.mesh, thickness, repair)?;
            repairs.extend(file.left_out.clone());
            let geometry = finish(mesh, false, repairs)?;
            let (placement, origin) = ((up, factor), geometry.origin - away);
            return Ok(BodyGeometry { placement, origin, file: Some(name.clone()), ..geometry });
        }
        let admitted = door::admit(&surface.mesh, repair).map_err(|error| error.to_string())?;
        let (mesh, report) = admitted;
        let repaired = (!report.is_clean()).then(|| report.to_string());
        let repairs = repaired.into_iter().chain(file.left_out.clone()).collect();
        let geometry = finish(mesh, false, repairs)?;
        surface.mesh.vertices.iter_mut().for_each(|v| *v += geometry.origin);
        Ok(BodyGeometry {
            placement: (up, factor),
            origin: geometry.origin - away,
            surface: (!surface.is_plain()).then(|| Arc::new(surface)),
            file: Some(name.clone()),
            ..geometry
        })
    }
}

/// The wall around a surface, and what was repaired of that.
fn walled(
    surface: &TriMesh,
    thickness: f64,
    repair: Repair,
) -> Result<(TriMesh, Vec<String>), String> {
    let admitted = door::admit_open(surface, repair).map_err(|error| error.to_string())?;
    let (surface, report) = admitted;
    if let Some((place, apart)) = door::near_miss(&surface, thickness) {
        let [x, y, z] = [place.x, place.y, place.z].map(tell);
        return Err(format!(
            "two edges of the surface come within {} m of each other at ({x}, {y}, {z}), less than \
             the thickness: they must be one edge, with the same corners, or lie farther apart",
            tell(apart)
        ));
    }
    let each = vec![thickness; surface.vertices.len()];
    let wall = thicken(&surface.vertices, &surface.triangles, &each);
    let wall = wall.map_err(|error| error.to_string())?;
    let (mesh, _) = door::admit(&wall, Repair::Refuse).map_err(|error| {
        format!("no wall of {} m goes around the surface: {error}", tell(thickness))
    })?;
    let repaired = RepairReport { volume: 0.0, ..report };
    let repairs = if repaired.is_clean() { Vec::new() } else { vec![report.to_string()] };
    Ok((mesh, repairs))
}

/// Takes the pictures that lie beside a mesh file into the scene, so that the recording has them.
/// What cannot be had is left out: pictures decide nothing.
fn take_pictures(surface: &SurfaceAttributes, name: &str, files: &mut Files) {
    let named = surface.materials.iter().filter_map(|of| of.texture.as_ref());
    for texture in named.filter(|of| of.length == 0) {
        let plain = !texture.name.contains(['/', '\\']);
        let end = texture.name.rsplit_once('.').map_or("", |(_, end)| end).to_lowercase();
        if plain && PICTURES.contains(&&end[..]) {
            files.get_up_to(&key(&folder_of(name), &texture.name), MOST_PICTURE_BYTES);
        }
    }
}

/// The bytes of a file that a mesh file names. That may come from anywhere: it names what lies in
/// its own folder or below, and nothing else.
pub(super) fn file_beside(files: &mut Files, mesh: &str, other: &str) -> Option<Arc<Vec<u8>>> {
    let below = other.split('/').all(|part| !part.is_empty() && part != "..");
    let plain = below && !other.contains(['\\', ':']);
    plain.then(|| files.get(&key(&folder_of(mesh), other)).ok()).flatten()
}

/// The place of an object among those of a mesh file.
fn named(surface: &SurfaceAttributes, file: &str, name: &str) -> Result<u32, String> {
    let names = &surface.object_names;
    if let Some(place) = names.iter().position(|it| it == name) {
        return Ok(place as u32);
    }
    if names.is_empty() {
        return Err(format!("{file} has no objects with names"));
    }
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let near = nearest(name, known.iter().copied());
    let near = near.map(|near| format!(": did you mean \"{near}\"?")).unwrap_or_default();
    let (first, more) = known.split_at(known.len().min(MOST_NAMES));
    let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
    let list = first.join("\", \"");
    Err(format!("there is no object \"{name}\" in {file}, which has \"{list}\"{more}{near}"))
}

fn full(count: usize) -> String {
    format!(
        "with it the scene's shapes would have {count} triangles; at most {MOST_TRIANGLES} are \
         taken, and equal shapes count once"
    )
}

/// The point turned so that `up` becomes z.
pub(super) fn upright(v: &Vec3, up: Axis) -> Vec3 {
    match up {
        Axis::X => Vec3::new(-v.z, v.y, v.x),
        Axis::Y => Vec3::new(v.x, -v.z, v.y),
        Axis::Z => *v,
    }
}

/// What a mesh is scaled by.
fn factor(mesh: &TriMesh, fit: Option<f64>, scale: Option<f64>) -> Result<f64, String> {
    let longest = longest_side(mesh);
    if longest <= 0.0 {
        return Err("the mesh has no extent".to_owned());
    }
    let factor = match (fit, scale) {
        (Some(fit), _) => fit / longest,
        (None, Some(scale)) => scale,
        (None, None) => 1.0,
    };
    let size = longest * factor;
    if !(MIN_SIZE..=MAX_SIZE).contains(&size) {
        return Err(format!(
            "the longest side is {} m; it must lie in [{}, {}] m: `fit` sets it",
            tell(size),
            tell(MIN_SIZE),
            tell(MAX_SIZE)
        ));
    }
    Ok(factor)
}

/// Middle of a mesh that lies farther from its origin than four times its size \[m\], else zero:
/// there, what is made of it would lose digits.
fn away(mesh: &TriMesh) -> Vec3 {
    let (low, high) = bounds(&mesh.vertices);
    let middle = (low + high) / 2.0;
    if middle.norm() > 4.0 * (high - low).max() { middle } else { Vec3::zeros() }
}

/// Moves a mesh so that its centroid is the origin; says what was taken off each corner \[m\].
fn centred(mesh: &mut TriMesh, size: f64) -> Vec3 {
    let mut moved = Vec3::zeros();
    // Once is enough, but for thin solids and those that lie far off.
    for _ in 0..3 {
        let centroid = mesh.mass_properties().centroid;
        if moved != Vec3::zeros() && centroid.norm() <= CENTRED * size {
            break;
        }
        mesh.vertices.iter_mut().for_each(|v| *v -= centroid);
        moved += centroid;
    }
    moved
}

fn longest_side(mesh: &TriMesh) -> f64 {
    let (low, high) = bounds(&mesh.vertices);
    (high - low).max()
}

/// Corners of the box around points; zero for none \[m\].
pub(super) fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let Some(first) = points.first() else {
        return (Vec3::zeros(), Vec3::zeros());
    };
    points.iter().fold((*first, *first), |(low, high), v| (low.inf(v), high.sup(v)))
}

fn finish(mut mesh: TriMesh, convex: bool, repairs: Vec<String>) -> Result<BodyGeometry, String> {
    let longest = longest_side(&mesh);
    if !(MIN_SIZE..=MAX_SIZE).contains(&longest) {
        return Err(format!(
            "the longest side must lie in [{}, {}] m; it is {}",
            tell(MIN_SIZE),
            tell(MAX_SIZE),
            tell(longest)
        ));
    }
    let mut mass = mesh.mass_properties();
    if mass.volume.is_nan() || mass.volume <= 0.0 {
        return Err(format!("the volume must be above 0 m³; it is {}", tell(mass.volume)));
    }
    let shift = centred(&mut mesh, longest);
    mass.centroid = Vec3::zeros();
    let bounds = bounds(&mesh.vertices);
    let solid = Solid::outer(mesh);
    // Of a ball all corners are kept, so that the world takes it for one.
    let whole = convex || hull::radius_of_ball(&solid.mesh.vertices).is_some();
    let hulls =
        if whole { vec![solid.mesh.vertices.clone()] } else { hull::convex_parts(&solid, HULLS) };
    Ok(BodyGeometry {
        solid: Arc::new(solid),
        hulls: Arc::new(hulls),
        mass,
        origin: -shift,
        bounds,
        repairs,
        placement: (Axis::Z, 1.0),
        surface: None,
        file: None,
    })
}

#[cfg(test)]
mod tests {
    use super::{Files, GeometryCache, GeometrySource, MOST_TRIANGLES, Shape};
    use cullet_document::files::Source;
    use std::collections::BTreeMap;

    #[test]
    fn shapes_are_bounded_together() {
        let cube = |edge: f64| GeometrySource::Shape(Shape::Box { size: [edge; 3] });
        let mut files = Files::new(Source::Bundle(BTreeMap::new()));
        let mut cache =
            GeometryCache { triangles: MOST_TRIANGLES - 24, ..GeometryCache::default() };
        for edge in [1.0, 2.0, 1.0, 2.0] {
            cache.get(&cube(edge), &mut files).expect("two shapes of 12 triangles");
        }
        let said = cache.get(&cube(3.0), &mut files).expect_err("a third one");
        assert!(said.contains("16000012 triangles; at most 16000000"), "{said}");
        assert!(cache.get(&cube(1.0), &mut files).is_ok(), "what is there is there");
    }
}
