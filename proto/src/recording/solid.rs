//! Solids in and out of recordings, to the last bit, and the digest that names them.

use super::Geometry;
use cullet_geometry::charts::charts;
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};

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

/// BLAKE3 over counts, coordinate bits, indices, tags and damage times, little-endian.
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
                bytes.extend(damage_time.to_bits().to_le_bytes());
                bytes.extend(front_speed.to_bits().to_le_bytes());
                bytes.extend(parent.to_le_bytes());
            }
        }
    }
    hasher.update(&bytes);
    *hasher.finalize().as_bytes()
}

impl From<&Solid> for Geometry {
    fn from(solid: &Solid) -> Self {
        let mut crack = Vec::with_capacity(solid.surface.len());
        let (mut times, mut speeds, mut parents) = (Vec::new(), Vec::new(), Vec::new());
        for surface in &solid.surface {
            match surface {
                Surface::Outer => crack.push(0),
                Surface::Crack { damage_time, front_speed, parent } => {
                    crack.push(1);
                    times.push(*damage_time);
                    speeds.push(*front_speed);
                    parents.push(*parent);
                }
            }
        }
        let (chart, charts) = charts(solid);
        let axes = charts.iter().flat_map(|chart| [chart.u, chart.v]);
        let chart_axes = axes.flat_map(|axis| [axis.x, axis.y, axis.z]).collect();
        Self {
            hash: geometry_hash(solid).to_vec(),
            vertices: solid.mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect(),
            triangles: solid.mesh.triangles.iter().flatten().copied().collect(),
            crack,
            damage_time: times,
            front_speed: speeds,
            parent: parents,
            chart,
            chart_axes,
        }
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
    length("damage_time", geometry.damage_time.len(), cracks)?;
    length("front_speed", geometry.front_speed.len(), cracks)?;
    length("parent", geometry.parent.len(), cracks)?;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&i| i as usize >= vertices.len()) {
            return Err(GeometryError::Index { triangle, vertex, vertices: vertices.len() });
        }
    }
    let mut crack = 0;
    let surface = geometry.crack.iter().map(|&kind| {
        if kind == 0 {
            return Surface::Outer;
        }
        crack += 1;
        Surface::Crack {
            damage_time: geometry.damage_time[crack - 1],
            front_speed: geometry.front_speed[crack - 1],
            parent: geometry.parent[crack - 1],
        }
    });
    let surface = surface.collect();
    Ok(Solid { mesh: TriMesh { vertices, triangles }, surface })
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
        solid.surface[1] = Surface::Crack { damage_time: 1.5e-5, front_speed: 900.0, parent: 4 };
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
    fn the_digest_sees_every_part_of_the_content() {
        let base = geometry_hash(&tetrahedron());
        let mut moved = tetrahedron();
        moved.mesh.vertices[2].y += 1e-15;
        let mut turned = tetrahedron();
        turned.mesh.triangles[0] = [2, 1, 0];
        let mut tagged = tetrahedron();
        tagged.surface[0] = Surface::crack(0.0);
        let mut later = tetrahedron();
        later.surface[1] = Surface::crack(1.6e-5);
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
