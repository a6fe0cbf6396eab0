//! What viewers draw: an object's whole state a message, so that jumping in time loses nothing.

use super::palette::{self, Rgb};
use super::trace::Trace;
use crate::pose_row::PoseRow;
use cullet_geometry::{Quat, Solid, Surface, Vec3};
use cullet_proto::recording::{Body, Tier};
use foxglove::bytes::{BufMut, Bytes, BytesMut};
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    Color, FrameTransform, FrameTransforms, KeyValuePair, LinePrimitive, PackedElementField,
    Point3, PointCloud, Pose, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate, Timestamp,
    TriangleListPrimitive, Vector3, line_primitive, scene_entity_deletion,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The frame that poses are given in.
pub(super) const WORLD: &str = "world";
/// The frame in which up is z, as viewers like it.
pub(super) const UPRIGHT: &str = "upright";

/// Most triangles of one body in the viewers' copy. Their messages carry an object's triangles
/// each time it moves; the lossless mesh is on `/geometry`.
const MAX_TRIANGLES: usize = 4_000;
/// Finest grid tried when a mesh is thinned, cells along the longest side.
const FINEST_GRID: u32 = 64;
/// An object of more fragments shares entities among them: viewers stall on thousands of entities.
const MAX_ENTITIES: usize = 100;

/// A body's triangles as viewers draw them, the surface and the crack faces apart.
#[derive(Debug, Default)]
pub(super) struct Shape {
    outer: Part,
    crack: Part,
}

#[derive(Debug, Default)]
struct Part {
    points: Vec<Point3>,
    indices: Vec<u32>,
}

/// A living body and where it is.
#[derive(Clone, Debug)]
pub(super) struct Live {
    pub(super) body: Body,
    pub(super) shape: Arc<Shape>,
    pub(super) row: Option<PoseRow>,
    /// Where cracks that end inside it meet its surface.
    pub(super) traces: Vec<Trace>,
    /// The colour of its crack faces, where the scene says so.
    pub(super) interior: Option<Rgb>,
}

impl Shape {
    pub(super) fn of(solid: &Solid) -> Self {
        let triangles = thinned(solid);
        let part = |crack: bool| {
            let mut part = Part::default();
            let mut seen: BTreeMap<u32, u32> = BTreeMap::new();
            for (corners, is_crack) in &triangles {
                if *is_crack != crack {
                    continue;
                }
                for &corner in corners {
                    let index = *seen.entry(corner).or_insert_with(|| {
                        let v = solid.mesh.vertices[corner as usize];
                        part.points.push(Point3 { x: v.x, y: v.y, z: v.z });
                        part.points.len() as u32 - 1
                    });
                    part.indices.push(index);
                }
            }
            part
        };
        Self { outer: part(false), crack: part(true) }
    }

    #[cfg(test)]
    pub(super) fn triangles(&self) -> usize {
        (self.outer.indices.len() + self.crack.indices.len()) / 3
    }
}

/// The triangles to draw, thinned by merging the vertices of a grid cell into its first one.
fn thinned(solid: &Solid) -> Vec<([u32; 3], bool)> {
    let tagged = || {
        let crack = solid.surface.iter().map(|s| matches!(s, Surface::Crack { .. }));
        solid.mesh.triangles.iter().copied().zip(crack)
    };
    if solid.mesh.triangles.len() <= MAX_TRIANGLES {
        return tagged().collect();
    }
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = Vec3::repeat(f64::NEG_INFINITY);
    for vertex in &solid.mesh.vertices {
        (low, high) = (low.inf(vertex), high.sup(vertex));
    }
    let mut cells = FINEST_GRID;
    loop {
        let size = (high - low).max() / f64::from(cells);
        let mut first: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        let stand_in: Vec<u32> = (0u32..)
            .zip(&solid.mesh.vertices)
            .map(|(index, vertex)| {
                let cell = (vertex - low) / size;
                let key = [cell.x as i64, cell.y as i64, cell.z as i64];
                *first.entry(key).or_insert(index)
            })
            .collect();
        let merged: Vec<_> = tagged()
            .map(|(corners, crack)| (corners.map(|i| stand_in[i as usize]), crack))
            .filter(|([a, b, c], _)| a != b && b != c && c != a)
            .collect();
        if merged.len() <= MAX_TRIANGLES || cells <= 4 {
            return merged;
        }
        cells = cells * 3 / 4;
    }
}

pub(super) fn timestamp(log_time: u64) -> Timestamp {
    let seconds = u32::try_from(log_time / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (log_time % 1_000_000_000) as u32)
}

pub(super) fn colour([r, g, b]: Rgb) -> Color {
    Color { r: r.into(), g: g.into(), b: b.into(), a: 1.0 }
}

pub(super) fn quaternion(rotation: &Quat) -> Quaternion {
    Quaternion { x: rotation.i, y: rotation.j, z: rotation.k, w: rotation.w }
}

/// The colours of a body: surface and crack faces.
fn colours(body: &Body) -> (Rgb, Rgb) {
    if body.fixed {
        return (palette::FIXED, palette::FIXED);
    }
    palette::colours(&body.material, &body.object, body.id)
}

/// The whole state of one object: everything of it before is deleted by the same message.
pub(super) fn scene_update(object: &str, log_time: u64, parts: &[&Live]) -> SceneUpdate {
    let time = timestamp(log_time);
    let group = parts.len().div_ceil(MAX_ENTITIES).max(1);
    let entities = parts.chunks(group).map(|group| entity(object, time, group)).collect();
    let deletion = SceneEntityDeletion {
        timestamp: Some(time),
        r#type: scene_entity_deletion::Type::All as i32,
        id: String::new(),
    };
    SceneUpdate { deletions: vec![deletion], entities }
}

fn entity(object: &str, time: Timestamp, group: &[&Live]) -> SceneEntity {
    let mut entity = SceneEntity {
        timestamp: Some(time),
        frame_id: WORLD.to_owned(),
        id: match group {
            [one] => one.body.name.clone(),
            [first, ..] => format!("{} and {} more", first.body.name, group.len() - 1),
            [] => object.to_owned(),
        },
        ..Default::default()
    };
    for live in group {
        let Some(row) = &live.row else { continue };
        let pose = pose(row);
        let (outer, crack) = colours(&live.body);
        let crack = live.interior.unwrap_or(crack);
        for (part, rgb) in [(&live.shape.outer, outer), (&live.shape.crack, crack)] {
            if !part.indices.is_empty() {
                entity.triangles.push(TriangleListPrimitive {
                    pose: Some(pose),
                    points: part.points.clone(),
                    color: Some(colour(rgb)),
                    colors: Vec::new(),
                    indices: part.indices.clone(),
                });
            }
        }
    }
    entity.lines = group.iter().filter_map(|live| lines(live)).collect();
    if let [one] = group {
        entity.metadata = facts(&one.body);
    }
    entity
}

/// The lines of a body's cracks, a pixel wide or two.
fn lines(live: &Live) -> Option<LinePrimitive> {
    let row = live.row.as_ref().filter(|_| !live.traces.is_empty())?;
    let ends = live.traces.iter().flat_map(|trace| trace.ends);
    Some(LinePrimitive {
        r#type: line_primitive::Type::LineList as i32,
        pose: Some(pose(row)),
        thickness: 2.0,
        scale_invariant: true,
        points: ends.map(|p| Point3 { x: p.x, y: p.y, z: p.z }).collect(),
        color: Some(colour(palette::dark(colours(&live.body).0))),
        colors: Vec::new(),
        indices: Vec::new(),
    })
}

fn pose(row: &PoseRow) -> Pose {
    let p = row.pose.translation.vector;
    Pose {
        position: Some(Vector3 { x: p.x, y: p.y, z: p.z }),
        orientation: Some(quaternion(&row.pose.rotation)),
    }
}

/// What a viewer shows of a body that was clicked.
fn facts(body: &Body) -> Vec<KeyValuePair> {
    let tier = Tier::try_from(body.tier).unwrap_or_default();
    let mut facts = vec![
        ("id", body.id.to_string()),
        ("object", body.object.clone()),
        ("material", body.material.clone()),
        ("mass [kg]", body.mass.to_string()),
        ("volume [m³]", body.volume.to_string()),
        ("tier", format!("{tier:?}").to_lowercase()),
        ("generation", body.generation.to_string()),
    ];
    if let Some(parent) = body.parent {
        facts.push(("parent", parent.to_string()));
    }
    let pair = |(key, value): (&str, String)| KeyValuePair { key: key.to_owned(), value };
    facts.into_iter().map(pair).collect()
}

/// Centres of the bodies that move, with the radius of a ball of equal volume and a colour that
/// goes from blue for whole objects to red for fragments of fragments.
pub(super) fn point_cloud<'a>(log_time: u64, bodies: impl Iterator<Item = &'a Live>) -> PointCloud {
    let mut data = BytesMut::new();
    for live in bodies {
        let Some(row) = &live.row else { continue };
        let p = row.pose.translation.vector;
        for value in [p.x, p.y, p.z, ball_radius(live.body.volume)] {
            data.put_f32_le(value as f32);
        }
        data.put_slice(match live.body.generation {
            0 => &[70, 120, 190, 255],
            1 => &[235, 160, 60, 255],
            _ => &[205, 60, 50, 255],
        });
    }
    let field = |(index, name): (usize, &str)| PackedElementField {
        name: name.to_owned(),
        offset: if index < 4 { 4 * index } else { 12 + index } as u32,
        r#type: if index < 4 { NumericType::Float32 } else { NumericType::Uint8 } as i32,
    };
    let names = ["x", "y", "z", "size", "red", "green", "blue", "alpha"];
    PointCloud {
        timestamp: Some(timestamp(log_time)),
        frame_id: WORLD.to_owned(),
        pose: Some(Pose {
            position: Some(Vector3::default()),
            orientation: Some(quaternion(&Quat::identity())),
        }),
        point_stride: 20,
        fields: names.into_iter().enumerate().map(field).collect(),
        data: Bytes::from(data),
    }
}

/// r with (4/3) π r³ = V.
fn ball_radius(volume: f64) -> f64 {
    libm::cbrt(volume * 0.75 / std::f64::consts::PI)
}

/// Middle \[m\] and radius \[m\] of the bodies that move and of these balls, in the upright frame.
pub(super) fn surroundings<'a>(
    bodies: impl Iterator<Item = &'a Live>,
    balls: Vec<(Vec3, f64)>,
    up: Vec3,
) -> (Vec3, f64) {
    let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    for live in bodies.filter(|live| !live.body.fixed) {
        let Some(row) = &live.row else { continue };
        let at = upright(up) * row.pose.translation.vector;
        let points = live.shape.outer.points.iter();
        let far = points.map(|p| p.x * p.x + p.y * p.y + p.z * p.z).fold(0.0, f64::max).sqrt();
        (low, high) = (low.inf(&at.add_scalar(-far)), high.sup(&at.add_scalar(far)));
    }
    for (centre, far) in balls {
        let at = upright(up) * centre;
        (low, high) = (low.inf(&at.add_scalar(-far)), high.sup(&at.add_scalar(far)));
    }
    let radius = (high - low).norm() / 2.0;
    if radius.is_finite() { ((low + high) / 2.0, radius.max(1e-3)) } else { (Vec3::zeros(), 1.0) }
}

/// The turn that makes `up` the z axis.
fn upright(up: Vec3) -> Quat {
    Quat::rotation_between(&up, &Vec3::z())
        .unwrap_or_else(|| Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI))
}

/// The one transform of a recording: the world turned so that `up` becomes z.
pub(super) fn frames(log_time: u64, up: Vec3) -> FrameTransforms {
    FrameTransforms {
        transforms: vec![FrameTransform {
            timestamp: Some(timestamp(log_time)),
            parent_frame_id: UPRIGHT.to_owned(),
            child_frame_id: WORLD.to_owned(),
            translation: Some(Vector3::default()),
            rotation: Some(quaternion(&upright(up))),
        }],
    }
}

/// A line for the viewers' log.
pub(super) fn log_line(
    log_time: u64,
    level: foxglove::messages::log::Level,
    message: String,
) -> foxglove::messages::Log {
    foxglove::messages::Log {
        timestamp: Some(timestamp(log_time)),
        level: level as i32,
        message,
        name: "cullet".to_owned(),
        file: String::new(),
        line: 0,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use cullet_geometry::TriMesh;

    /// A closed torus-like grid of `n`×`n` quads.
    pub(crate) fn ring(n: u32) -> Solid {
        let tau = std::f64::consts::TAU;
        let vertex = |i: u32| {
            let (u, v) = (f64::from(i / n) / f64::from(n), f64::from(i % n) / f64::from(n));
            let r = 1.0 + 0.3 * libm::cos(tau * v);
            Vec3::new(r * libm::cos(tau * u), r * libm::sin(tau * u), 0.3 * libm::sin(tau * v))
        };
        let at = |i: u32, j: u32| (i % n) * n + j % n;
        let quad = |k: u32| {
            let (i, j) = (k / n, k % n);
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..n * n).flat_map(quad).collect();
        Solid::outer(TriMesh { vertices: (0..n * n).map(vertex).collect(), triangles })
    }

    #[test]
    fn small_meshes_are_drawn_whole_and_large_ones_thinned() {
        assert_eq!(Shape::of(&ring(40)).triangles(), 3_200);
        let thin = Shape::of(&ring(150)).triangles();
        assert!((MAX_TRIANGLES / 4..=MAX_TRIANGLES).contains(&thin), "{thin}");
    }

    #[test]
    fn crack_faces_are_a_part_of_their_own() {
        let mut solid = ring(8);
        solid.surface[..10].fill(Surface::crack(0.0));
        let shape = Shape::of(&solid);
        assert_eq!((shape.crack.indices.len(), shape.outer.indices.len()), (30, 3 * 118));
        assert!(shape.crack.points.len() < 20);
    }

    #[test]
    fn up_becomes_z() {
        for up in [Vec3::y(), Vec3::z(), -Vec3::z(), -Vec3::x()] {
            let frames = frames(0, up);
            let q = frames.transforms[0].rotation.expect("is set");
            let turn = Quat::new_normalize(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
            assert!((turn * up - Vec3::z()).norm() < 1e-12, "{up:?}");
        }
    }
}
