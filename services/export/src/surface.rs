//! Meshes as other programs want them: corners with normals and texture coordinates, the skin and
//! the crack faces apart.

use cullet_geometry::{Solid, Surface, Vec3};
use cullet_proto::recording::Geometry;

/// Faces that meet at less than this are shaded as one curved surface: cosine of 30°. A crack face
/// is never smoothed with the skin.
const CREASE: f64 = 0.866_025_403_784_438_6;

/// What the corners of a face of the skin have beside their places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinAttributes {
    /// Texture coordinates of the three corners of each triangle of the solid, in their order;
    /// those of crack faces are not used. `None`: the skin has none.
    pub uv: Option<Vec<[[f32; 2]; 3]>>,
    /// Normals likewise. `None`: they are made from the faces.
    pub normals: Option<Vec<[Vec3; 3]>>,
}

/// What is known of a crack at the corners of its faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CrackMark {
    /// Time from the impact to full damage \[s\].
    pub(crate) damage_time: [f32; 3],
    /// Speed of the crack front \[m/s\].
    pub(crate) front_speed: [f32; 3],
    /// The body that broke there; −1 where it is not known.
    pub(crate) parent: i64,
}

/// A face with its three corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExportFace {
    /// Vertices of the solid.
    pub(crate) corners: [u32; 3],
    pub(crate) normals: [Vec3; 3],
    pub(crate) uv: Option<[[f32; 2]; 3]>,
    /// Of a crack face; `None` of one of the skin.
    pub(crate) crack: Option<CrackMark>,
}

/// A solid as it is written, in its body's frame \[m\].
#[derive(Clone, Debug)]
pub(crate) struct ExportMesh {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) faces: Vec<ExportFace>,
    /// Diagonal of its bounding box \[m\].
    pub(crate) diagonal: f64,
}

impl ExportMesh {
    /// `geometry` is what `solid` was recorded as: it has the texture coordinates of crack faces.
    pub(crate) fn of(solid: &Solid, geometry: &Geometry, skin: &SkinAttributes) -> Self {
        let smooth = normals(solid);
        let chart = geometry.uv.as_chunks::<2>().0;
        let mut interior = geometry.corner.as_chunks::<3>().0.iter();
        let mut faces = Vec::with_capacity(solid.mesh.triangles.len());
        for (t, &corners) in solid.mesh.triangles.iter().enumerate() {
            let (mut normals, mut crack) = (smooth[t], None);
            let uv = match solid.surface[t] {
                Surface::Outer => {
                    let own = skin.normals.as_ref().and_then(|all| all.get(t));
                    normals = own.copied().unwrap_or(normals);
                    skin.uv.as_ref().and_then(|all| all.get(t)).copied()
                }
                Surface::Crack { damage_time, front_speed, parent } => {
                    let parent = i64::from(parent) - 1;
                    crack = Some(CrackMark { damage_time, front_speed, parent });
                    let at = |i: &u32| chart.get(*i as usize).copied().unwrap_or_default();
                    interior.next().map(|own| own.each_ref().map(at))
                }
            };
            faces.push(ExportFace { corners, normals, uv, crack });
        }
        let diagonal = solid.mesh.diagonal();
        Self { vertices: solid.mesh.vertices.clone(), faces, diagonal }
    }

    /// Least and greatest damage time \[s\]; `None` of a body without crack faces.
    pub(crate) fn damage_range(&self) -> Option<[f32; 2]> {
        let times = self.faces.iter().filter_map(|face| face.crack).flat_map(|m| m.damage_time);
        times.fold(None, |range, time| {
            let [low, high] = range.unwrap_or([time; 2]);
            Some([low.min(time), high.max(time)])
        })
    }

    /// Corners of the bounding box \[m\].
    pub(crate) fn bounds(&self) -> [Vec3; 2] {
        let mut bounds = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        for vertex in &self.vertices {
            bounds = [bounds[0].inf(vertex), bounds[1].sup(vertex)];
        }
        bounds
    }
}

/// The normal at each corner: the mean, by area, of the faces of one kind that meet there without
/// a crease.
fn normals(solid: &Solid) -> Vec<[Vec3; 3]> {
    let mesh = &solid.mesh;
    let area = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(&(c - a))
    };
    let areas: Vec<Vec3> = (0..mesh.triangles.len()).map(area).collect();
    let unit = |n: &Vec3| n.try_normalize(1e-300);
    let units: Vec<Option<Vec3>> = areas.iter().map(unit).collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); mesh.vertices.len()];
    for (t, corners) in (0u32..).zip(&mesh.triangles) {
        corners.iter().for_each(|&v| around[v as usize].push(t));
    }
    let crack: Vec<bool> = solid.surface.iter().map(Surface::is_crack).collect();
    let normal = |t: usize, v: u32| {
        // A face without area has whatever its corner has.
        let level = |other: &usize| match (units[t], units[*other]) {
            (Some(own), Some(other)) => own.dot(&other) > CREASE,
            _ => units[t].is_none(),
        };
        let alike = around[v as usize].iter().map(|&other| other as usize);
        let alike = alike.filter(|&other| crack[other] == crack[t]).filter(level);
        unit(&alike.map(|other| areas[other]).sum::<Vec3>()).unwrap_or_else(Vec3::z)
    };
    let corners = mesh.triangles.iter().enumerate();
    corners.map(|(t, corners)| corners.map(|v| normal(t, v))).collect()
}
