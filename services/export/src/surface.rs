//! Meshes as other programs want them: corners with normals and texture coordinates, the skin and
//! the crack faces apart. What the artist's mesh had beside its shape is on the skin again.

use crate::pictures::ArtistMaterial;
use cullet_geometry::attributes::{AttributeTransfer, SkinTriangle, SurfaceAttributes};
use cullet_geometry::{Solid, Surface, Vec3};
use cullet_proto::recording::Geometry;
use cullet_record::skin_of;
use std::collections::HashMap;
use std::sync::Arc;

/// Faces that meet at less than this are shaded as one curved surface: cosine of 30°. A crack face
/// is never smoothed with the skin.
const CREASE: f64 = 0.866_025_403_784_438_6;

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
    /// Of a face of the skin: the place of its material among those of the artist's mesh.
    pub(crate) slot: Option<u32>,
}

/// What decides the material of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FaceKind {
    /// The surface that the object was made with, where its file names no materials.
    Skin,
    /// The same, of that material of its file.
    Slot(u32),
    /// A crack face.
    Crack,
    /// A crack that ends inside its body.
    OpenCrack,
}

impl ExportFace {
    pub(crate) fn kind(&self) -> FaceKind {
        match (self.crack, self.slot) {
            (Some(_), _) => FaceKind::Crack,
            (None, Some(slot)) => FaceKind::Slot(slot),
            (None, None) => FaceKind::Skin,
        }
    }
}

/// The artist's mesh of a body of the scene, made ready to be asked for what it has by place.
#[derive(Debug)]
pub(crate) struct ArtistSurface<'a> {
    surface: &'a SurfaceAttributes,
    transfer: AttributeTransfer<'a>,
    /// Its materials; none where its file names none.
    materials: Arc<Vec<ArtistMaterial>>,
}

impl<'a> ArtistSurface<'a> {
    pub(crate) fn new(surface: &'a SurfaceAttributes, materials: Vec<ArtistMaterial>) -> Self {
        let (transfer, materials) = (AttributeTransfer::new(surface), Arc::new(materials));
        Self { surface, transfer, materials }
    }
}

/// A solid as it is written, in its body's frame \[m\].
#[derive(Clone, Debug)]
pub(crate) struct ExportMesh {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) faces: Vec<ExportFace>,
    /// Diagonal of its bounding box \[m\].
    pub(crate) diagonal: f64,
    /// Materials of the artist's mesh, by slot.
    pub(crate) materials: Arc<Vec<ArtistMaterial>>,
}

impl ExportMesh {
    /// `geometry` is what `solid` was recorded as: it has the texture coordinates of crack faces.
    /// `artist`: the mesh of the object that it is a part of, and where it lay in that.
    pub(crate) fn of(
        solid: &Solid,
        geometry: &Geometry,
        artist: Option<(&ArtistSurface<'_>, Vec3)>,
    ) -> Self {
        let smooth = normals(solid);
        let chart = geometry.uv.as_chunks::<2>().0;
        let mut interior = geometry.corner.as_chunks::<3>().0.iter();
        let mut faces = Vec::with_capacity(solid.mesh.triangles.len());
        for (t, &corners) in solid.mesh.triangles.iter().enumerate() {
            let normals = smooth[t];
            match solid.surface[t] {
                Surface::Outer if artist.is_some() => {}
                Surface::Outer => {
                    faces.push(ExportFace { corners, normals, uv: None, crack: None, slot: None });
                }
                Surface::Crack { damage_time, front_speed, parent } => {
                    let parent = i64::from(parent) - 1;
                    let crack = Some(CrackMark { damage_time, front_speed, parent });
                    let at = |i: &u32| chart.get(*i as usize).copied().unwrap_or_default();
                    let uv = interior.next().map(|own| own.each_ref().map(at));
                    faces.push(ExportFace { corners, normals, uv, crack, slot: None });
                }
            }
        }
        let mut mesh = Self {
            vertices: solid.mesh.vertices.clone(),
            faces,
            diagonal: solid.mesh.diagonal(),
            materials: Arc::default(),
        };
        if let Some((artist, origin)) = artist {
            mesh.materials = Arc::clone(&artist.materials);
            mesh.add_skin(solid, &smooth, artist, origin);
        }
        mesh
    }

    /// Adds the skin with the attributes of the artist's mesh: a face of the solid may become
    /// several, where it spans several of the artist's that do not continue each other.
    fn add_skin(
        &mut self,
        solid: &Solid,
        smooth: &[[Vec3; 3]],
        ArtistSurface { surface, transfer, materials }: &ArtistSurface<'_>,
        origin: Vec3,
    ) {
        let bits = |p: &Vec3| [p.x.to_bits(), p.y.to_bits(), p.z.to_bits()];
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        for SkinTriangle { of, corners, uv, normals, slot, .. } in skin_of(transfer, solid, origin)
        {
            let (own, places) = (solid.mesh.triangles[of], solid.mesh.corners(of));
            let mut face = ExportFace {
                corners: own,
                normals: smooth[of],
                uv: (!surface.uv.is_empty()).then_some(uv),
                crack: None,
                slot: (!materials.is_empty()).then_some(slot),
            };
            for k in 0..3 {
                let same = places.iter().position(|place| bits(place) == bits(&corners[k]));
                face.corners[k] = same.map_or_else(
                    || {
                        *known.entry(bits(&corners[k])).or_insert_with(|| {
                            self.vertices.push(corners[k]);
                            self.vertices.len() as u32 - 1
                        })
                    },
                    |same| own[same],
                );
                let given = Vec3::from(normals[k].map(f64::from));
                let made = same.map_or(given, |same| smooth[of][same]);
                face.normals[k] = if surface.normals.is_empty() { made } else { given };
            }
            self.faces.push(face);
        }
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
