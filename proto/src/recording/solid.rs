//! Solids in and out of recordings, to the last bit, and the digest that names them.

use super::{Cracks, Geometry};
use cullet_geometry::charts::charts;
use cullet_geometry::mesh::MeshError;
use cullet_geometry::{Sheet, Solid, Surface, TriMesh, Vec3};
use std::collections::BTreeMap;

/// Why a recorded geometry is not a solid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeometryError {
    /// A column has the wrong length.
    #[error("{column} has {length} entries, {wanted} are needed")]
    Length {
        /// Which column.
        column: &'static str,
        /// Its entries.
        length: usize,
        /// What the other columns call for.
        wanted: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex} of {vertices}")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// The content does not have the digest it is filed under.
    #[error("the content does not match its digest")]
    Digest,
}

/// BLAKE3 over counts, coordinate bits, indices and what each face is, little-endian.
#[must_use]
pub fn geometry_hash(solid: &Solid) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    let mut bytes = Vec::new();
    bytes.extend((solid.mesh.vertices.len() as u64).to_le_bytes());
    bytes.extend((solid.mesh.triangles.len() as u64).to_le_bytes());
    for vertex in &solid.mesh.vertices {
        vertex.iter().for_each(|c| bytes.extend(c.to_bits().to_le_bytes()));
    }
    hasher.update(&bytes);
    bytes.clear();
    for triangle in &solid.mesh.triangles {
        triangle.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    }
    for surface in &solid.surface {
        match surface {
            Surface::Outer => bytes.push(0),
            Surface::Crack { damage_time, front_speed, parent } => {
                bytes.push(1);
                for mark in damage_time.iter().chain(front_speed) {
                    bytes.extend(mark.to_bits().to_le_bytes());
                }
                bytes.extend(parent.to_le_bytes());
            }
        }
    }
    hasher.update(&bytes);
    *hasher.finalize().as_bytes()
}

impl From<&Solid> for Geometry {
    fn from(solid: &Solid) -> Self {
        Self::with_materials(solid, |_| 0)
    }
}

/// What tells interior vertices apart: vertex, chart, bits of time and speed. A chart has one
/// parent.
type InteriorKey = (u32, u32, u32, u32);

impl Geometry {
    /// The columns of a solid. `material`: the number of the material that a `parent` was of.
    #[must_use]
    pub fn with_materials(solid: &Solid, material: impl Fn(u32) -> u32) -> Self {
        let crack = solid.surface.iter().map(|surface| u8::from(surface.is_crack()));
        let mut geometry = Self {
            hash: geometry_hash(solid).to_vec(),
            vertices: solid.mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect(),
            triangles: solid.mesh.triangles.iter().flatten().copied().collect(),
            crack: crack.collect(),
            ..Self::default()
        };
        let (chart, charts) = charts(solid);
        let faces = solid.mesh.triangles.iter().zip(&solid.surface);
        let cracks = faces.filter(|(_, surface)| surface.is_crack());
        let mut known: BTreeMap<InteriorKey, u32> = BTreeMap::new();
        for ((corners, surface), &chart) in cracks.zip(&chart) {
            let Surface::Crack { damage_time, front_speed, parent } = *surface else { continue };
            for ((&vertex, time), speed) in corners.iter().zip(damage_time).zip(front_speed) {
                let next = geometry.interior_vertex.len() as u32;
                let key = (vertex, chart, time.to_bits(), speed.to_bits());
                let name = *known.entry(key).or_insert(next);
                geometry.corner.push(name);
                if name < next {
                    continue;
                }
                let place = solid.mesh.vertices[vertex as usize];
                let axes = &charts[chart as usize];
                geometry.uv.extend([axes.u, axes.v].map(|axis| axis.dot(&place) as f32));
                geometry.interior_vertex.push(vertex);
                geometry.damage_time.push(time);
                geometry.front_speed.push(speed);
                geometry.parent.push(parent);
                geometry.material.push(material(parent));
            }
        }
        geometry
    }
}

impl TryFrom<&Geometry> for Solid {
    type Error = GeometryError;

    fn try_from(geometry: &Geometry) -> Result<Self, GeometryError> {
        let solid = columns(geometry)?;
        if geometry.hash == geometry_hash(&solid) { Ok(solid) } else { Err(GeometryError::Digest) }
    }
}

fn columns(geometry: &Geometry) -> Result<Solid, GeometryError> {
    let vertices: Vec<Vec3> =
        geometry.vertices.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2])).collect();
    length("vertices", geometry.vertices.len(), 3 * vertices.len())?;
    let triangles: Vec<[u32; 3]> =
        geometry.triangles.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    length("triangles", geometry.triangles.len(), 3 * triangles.len())?;
    length("crack", geometry.crack.len(), triangles.len())?;
    let cracks = geometry.crack.iter().filter(|&&c| c != 0).count();
    let interior = geometry.interior_vertex.len();
    length("corner", geometry.corner.len(), 3 * cracks)?;
    length("uv", geometry.uv.len(), 2 * interior)?;
    length("damage_time", geometry.damage_time.len(), interior)?;
    length("front_speed", geometry.front_speed.len(), interior)?;
    length("parent", geometry.parent.len(), interior)?;
    length("material", geometry.material.len(), interior)?;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&i| i as usize >= vertices.len()) {
            return Err(GeometryError::Index { triangle, vertex, vertices: vertices.len() });
        }
    }
    let mut own = geometry.corner.as_chunks::<3>().0.iter();
    let mut surface = Vec::with_capacity(triangles.len());
    for (triangle, corners) in triangles.iter().enumerate() {
        let interior = if geometry.crack[triangle] == 0 { None } else { own.next() };
        surface.push(match interior {
            None => Surface::Outer,
            Some(interior) => face(geometry, triangle, corners, interior)?,
        });
    }
    Ok(Solid { mesh: TriMesh { vertices, triangles }, surface })
}

impl Cracks {
    /// The columns of a sheet of a body.
    #[must_use]
    pub fn of(body: u64, step: u64, time: f64, sheet: &Sheet) -> Self {
        Self {
            body,
            step,
            time,
            vertices: sheet.mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect(),
            triangles: sheet.mesh.triangles.iter().flatten().copied().collect(),
            damage_time: sheet.damage_time.clone(),
            front_speed: sheet.front_speed.clone(),
        }
    }
}

impl TryFrom<&Cracks> for Sheet {
    type Error = MeshError;

    fn try_from(cracks: &Cracks) -> Result<Self, MeshError> {
        let vertices = cracks.vertices.as_chunks::<3>().0;
        let mesh = TriMesh {
            vertices: vertices.iter().map(|&[x, y, z]| Vec3::new(x, y, z)).collect(),
            triangles: cracks.triangles.as_chunks::<3>().0.to_vec(),
        };
        let (damage_time, front_speed) = (cracks.damage_time.clone(), cracks.front_speed.clone());
        let sheet = Self { mesh, damage_time, front_speed };
        sheet.validate().map(|()| sheet)
    }
}

/// The crack face with these corners, from its interior vertices.
fn face(
    geometry: &Geometry,
    triangle: usize,
    corners: &[u32; 3],
    interior: &[u32; 3],
) -> Result<Surface, GeometryError> {
    let vertices = geometry.interior_vertex.len();
    for (&name, corner) in interior.iter().zip(corners) {
        let at = geometry.interior_vertex.get(name as usize);
        if at != Some(corner) {
            return Err(GeometryError::Index { triangle, vertex: name, vertices });
        }
    }
    let [a, b, c] = interior.map(|name| name as usize);
    let of = |column: &[f32]| [column[a], column[b], column[c]];
    let (damage_time, front_speed) = (of(&geometry.damage_time), of(&geometry.front_speed));
    Ok(Surface::Crack { damage_time, front_speed, parent: geometry.parent[a] })
}

fn length(column: &'static str, length: usize, wanted: usize) -> Result<(), GeometryError> {
    if length == wanted { Ok(()) } else { Err(GeometryError::Length { column, length, wanted }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Body, JobReport, Recorded, RunEvent, schema_bytes};
    use foxglove::prost_types::FileDescriptorSet;
    use prost::Message;

    fn tetrahedron() -> Solid {
        let vertices = vec![
            Vec3::new(0.1, 0.0, -0.0),
            Vec3::new(1.0 / 3.0, 0.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(0.0, 0.0, f64::MIN_POSITIVE),
        ];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let mut solid = Solid::outer(TriMesh { vertices, triangles });
        let (damage_time, front_speed) = ([1.5e-5, 1.6e-5, 1.7e-5], [900.0, 0.0, 800.0]);
        solid.surface[1] = Surface::Crack { damage_time, front_speed, parent: 4 };
        solid.surface[3] = Surface::crack(0.0);
        solid
    }

    #[test]
    fn a_solid_survives_to_the_last_bit() {
        let solid = tetrahedron();
        let bytes = Geometry::from(&solid).to_bytes();
        let read = Geometry::from_bytes(&bytes).expect("decodes");
        let back = Solid::try_from(&read).expect("is a solid");
        assert_eq!(back, solid);
        let bits = |s: &Solid| {
            s.mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).map(f64::to_bits).collect()
        };
        let (a, b): (Vec<u64>, Vec<u64>) = (bits(&solid), bits(&back));
        assert_eq!(a, b, "the sign of zero counts");
    }

    #[test]
    fn a_sheet_survives_and_a_damaged_one_is_refused() {
        let mesh = TriMesh {
            vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            triangles: vec![[0, 1, 2]],
        };
        let sheet = Sheet { mesh, damage_time: vec![1e-5; 3], front_speed: vec![0.0, 9.0, 8.0] };
        let cracks = Cracks::of(3, 4, 0.5, &sheet);
        let read = Cracks::from_bytes(&cracks.to_bytes()).expect("decodes");
        assert_eq!(Sheet::try_from(&read), Ok(sheet));
        let mut short = read.clone();
        short.damage_time.pop();
        let refused = Err(MeshError::Marks { marks: 2, vertices: 3 });
        assert_eq!(Sheet::try_from(&short), refused);
        let mut wild = read;
        wild.triangles[1] = 7;
        assert!(Sheet::try_from(&wild).is_err());
    }

    #[test]
    fn interior_vertices_are_doubled_only_where_they_differ() {
        // A cube cracked on two sides that meet at a right angle: two charts, one edge in common.
        let size = Vec3::new(1.0, 2.0, 3.0);
        let mesh = cullet_geometry::shapes::cuboid(size, Default::default()).expect("a box");
        let mut solid = Solid::outer(mesh);
        let height = |p: Vec3| (p.z + 1.5) as f32;
        for t in 0..solid.mesh.triangles.len() {
            let [a, b, c] = solid.mesh.corners(t);
            let normal = (b - a).cross(&(c - a)).normalize();
            if normal.z > 0.5 || normal.x > 0.5 {
                let damage_time = [a, b, c].map(height);
                let parent = 8;
                solid.surface[t] = Surface::Crack { damage_time, front_speed: [0.0; 3], parent };
            }
        }
        let geometry = Geometry::with_materials(&solid, |parent| 10 * parent);
        assert_eq!((geometry.corner.len(), geometry.interior_vertex.len()), (12, 8));
        assert_eq!((&geometry.parent[..], &geometry.material[..]), (&[8; 8][..], &[80; 8][..]));
        for (interior, &vertex) in geometry.interior_vertex.iter().enumerate() {
            let place = solid.mesh.vertices[vertex as usize];
            assert_eq!(geometry.damage_time[interior], height(place));
        }
        // Texture coordinates measure in metres along every edge of a flat chart.
        for corners in geometry.corner.as_chunks::<3>().0 {
            for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(p, q)| (corners[p], corners[q])) {
                let place =
                    |i: u32| solid.mesh.vertices[geometry.interior_vertex[i as usize] as usize];
                let uv = |i: u32| geometry.uv.as_chunks::<2>().0[i as usize];
                let ([a, b], [c, d]) = (uv(p), uv(q));
                let flat = f64::from((a - c).hypot(b - d));
                assert!((flat - (place(p) - place(q)).norm()).abs() < 1e-6);
            }
        }
        assert_eq!(Solid::try_from(&geometry), Ok(solid));
    }

    #[test]
    fn the_digest_sees_every_part_of_the_content() {
        let base = geometry_hash(&tetrahedron());
        let mut moved = tetrahedron();
        moved.mesh.vertices[2].y += 1e-15;
        let mut turned = tetrahedron();
        turned.mesh.triangles[0] = [2, 1, 0];
        let mut tagged = tetrahedron();
        tagged.surface[0] = Surface::crack(0.0);
        let mut later = tetrahedron();
        if let Surface::Crack { damage_time, .. } = &mut later.surface[1] {
            damage_time[2] *= 2.0;
        }
        for (what, other) in
            [("vertex", moved), ("triangle", turned), ("tag", tagged), ("time", later)]
        {
            assert_ne!(geometry_hash(&other), base, "{what}");
        }
    }

    #[test]
    fn damaged_columns_are_refused_by_name() {
        let good = Geometry::from(&tetrahedron());
        let mut odd = good.clone();
        odd.vertices.pop();
        let refused = Solid::try_from(&odd);
        assert!(matches!(refused, Err(GeometryError::Length { column: "vertices", .. })));
        let mut wild = good.clone();
        wild.triangles[4] = 9;
        let expected = GeometryError::Index { triangle: 1, vertex: 9, vertices: 4 };
        assert_eq!(Solid::try_from(&wild), Err(expected));
        let mut other = good.clone();
        other.vertices[0] += 1.0;
        assert_eq!(Solid::try_from(&other), Err(GeometryError::Digest));
        let mut bare = good;
        bare.damage_time.pop();
        let refused = Solid::try_from(&bare);
        assert!(matches!(refused, Err(GeometryError::Length { column: "damage_time", .. })));
    }

    #[test]
    fn the_embedded_schema_describes_every_field() {
        let set = FileDescriptorSet::decode(&schema_bytes()[..]).expect("a descriptor set");
        let file = &set.file[0];
        let message =
            |name: &str| file.message_type.iter().find(|m| m.name() == name).expect("is declared");
        let field = |m: &str, f: &str| {
            message(m).field.iter().find(|x| x.name() == f).cloned().expect("is declared")
        };
        use foxglove::prost_types::field_descriptor_proto::{Label, Type};
        let parent = field("Body", "parent");
        assert_eq!((parent.number(), parent.r#type()), (4, Type::Uint64));
        assert!(parent.proto3_optional());
        assert_eq!(message("Body").oneof_decl[0].name(), "_parent");
        let tier = field("Body", "tier");
        assert_eq!((tier.r#type(), tier.type_name()), (Type::Enum, ".cullet.Tier"));
        let hits = field("JobReport", "hits");
        assert_eq!((hits.label(), hits.type_name()), (Label::Repeated, ".cullet.Hit"));
        let crack = field("Geometry", "crack");
        assert_eq!((crack.r#type(), crack.label()), (Type::Bytes, Label::Optional));
        let names: Vec<_> =
            file.message_type.iter().map(|m| format!("cullet.{}", m.name())).collect();
        for name in [Body::NAME, JobReport::NAME, RunEvent::NAME, Geometry::NAME] {
            assert!(names.iter().any(|n| n == name), "{name}");
        }
        let kinds = file.enum_type.iter().find(|e| e.name() == "EventKind").expect("is declared");
        assert_eq!(kinds.value[3].name(), "EVENTKIND_JOB_OPENED");
    }
}
