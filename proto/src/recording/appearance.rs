//! What bodies look like, beside the messages that decide: the artist's surface, and where
//! fragments lay in it.

use super::schema::{MessageDeclaration, message};
use cullet_geometry::attributes::{
    AttributeError, SurfaceAttributes, SurfaceMaterial, SurfaceTexture, TextureMapping, TextureWrap,
};
use cullet_geometry::{TriMesh, Vec3};
use std::collections::BTreeMap;

message! {
    /// What the mesh file of bodies has beside their shape: the surface as it is in the file, in
    /// the frame in which these bodies were recorded at their birth. Decides nothing and is left
    /// out of the digest.
    Appearance {
        /// The bodies of the scene whose surface it is.
        "1" [uint64, repeated] bodies: Vec<u64>,
        /// The mesh file: the attachment of that name.
        "2" [string] file: String,
        /// x, y, z of each vertex \[m\].
        "3" [double, repeated] vertices: Vec<f64>,
        /// Three vertex indices a triangle, as in the file.
        "4" [uint32, repeated] triangles: Vec<u32>,
        /// u, v of each texture coordinate; v grows upward.
        "5" [float, repeated] uv: Vec<f32>,
        /// Of each corner of each triangle: its texture coordinate. Empty without any.
        "6" [uint32, repeated] uv_corner: Vec<u32>,
        /// x, y, z of each unit normal.
        "7" [float, repeated] normals: Vec<f32>,
        /// Of each corner of each triangle: its normal. Empty without any.
        "8" [uint32, repeated] normal_corner: Vec<u32>,
        /// Of each triangle: its material. Empty without any.
        "9" [uint32, repeated] slots: Vec<u32>,
        /// The materials.
        "10" [message, repeated] materials: Vec<AppearanceMaterial>,
        /// Of each triangle: its object in the mesh file. Empty without any.
        "11" [uint32, repeated] objects: Vec<u32>,
        /// Names of the objects.
        "12" [string, repeated] object_names: Vec<String>,
    }
}

message! {
    /// How a part of a surface is to look.
    AppearanceMaterial {
        /// What the mesh file calls it.
        "1" [string] name: String,
        /// Linear red, green, blue and opacity.
        "2" [float, repeated] base_colour: Vec<f32>,
        /// From 0, a dielectric, to 1, a metal.
        "3" [float] metallic: f32,
        /// From 0, a mirror, to 1, matt.
        "4" [float] roughness: f32,
        /// The picture that multiplies the base colour.
        "5" [message, optional] texture: Option<AppearanceTexture>,
    }
}

message! {
    /// A picture: a part of the mesh file, or what that names.
    AppearanceTexture {
        /// What the mesh file calls it, or the path that it gives.
        "1" [string] name: String,
        /// Media type; empty where it is not known.
        "2" [string] media_type: String,
        /// Where it begins in the mesh file \[bytes\].
        "3" [uint64] offset: u64,
        /// Its length \[bytes\]; 0 where it is no part of the file.
        "4" [uint64] length: u64,
        /// How texture coordinates lead into it, as KHR_texture_transform of glTF has it: offset
        /// of u and of v (downward), rotation \[rad\], scale of u and of v. Empty: as they are.
        "5" [float, repeated] transform: Vec<f32>,
        /// How it goes on beyond [0, 1] along u and v: 0 again, 1 mirrored, 2 its border. Empty:
        /// again.
        "6" [uint32, repeated] wrap: Vec<u32>,
    }
}

pub(super) fn declarations() -> Vec<MessageDeclaration> {
    vec![
        Appearance::declaration(),
        AppearanceMaterial::declaration(),
        AppearanceTexture::declaration(),
    ]
}

/// Why a recorded appearance is no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AppearanceError {
    /// A column has a length that the others do not allow.
    #[error("{column} has {length} entries, {wanted} are needed")]
    Column {
        /// Which column.
        column: &'static str,
        /// Its entries.
        length: usize,
        /// What the others call for.
        wanted: usize,
    },
    /// A corner names a value that is not there.
    #[error("corner {corner} names entry {index} of the {count} in {column}")]
    Corner {
        /// Which corner, counted over all triangles.
        corner: usize,
        /// Which column.
        column: &'static str,
        /// What it names.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// The surface that they make is not sound.
    #[error(transparent)]
    Surface(#[from] AttributeError),
}

impl Appearance {
    /// The columns of a surface of these bodies, from the mesh file that is attached under `file`.
    #[must_use]
    pub fn of(bodies: Vec<u64>, file: &str, surface: &SurfaceAttributes) -> Self {
        let (uv, uv_corner) = shared(&surface.uv);
        let (normals, normal_corner) = shared(&surface.normals);
        Self {
            bodies,
            file: file.to_owned(),
            vertices: surface.mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect(),
            triangles: surface.mesh.triangles.iter().flatten().copied().collect(),
            uv,
            uv_corner,
            normals,
            normal_corner,
            slots: surface.slots.clone(),
            materials: surface.materials.iter().map(AppearanceMaterial::from).collect(),
            objects: surface.objects.clone(),
            object_names: surface.object_names.clone(),
        }
    }
}

impl TryFrom<&Appearance> for SurfaceAttributes {
    type Error = AppearanceError;

    fn try_from(it: &Appearance) -> Result<Self, AppearanceError> {
        whole("vertices", it.vertices.len(), 3)?;
        whole("triangles", it.triangles.len(), 3)?;
        let vertices = it.vertices.as_chunks::<3>().0.iter().map(|&p| Vec3::from(p)).collect();
        let triangles = it.triangles.as_chunks::<3>().0.to_vec();
        let surface = Self {
            mesh: TriMesh { vertices, triangles },
            uv: own("uv", &it.uv, &it.uv_corner)?,
            normals: own("normals", &it.normals, &it.normal_corner)?,
            slots: it.slots.clone(),
            materials: it.materials.iter().map(SurfaceMaterial::from).collect(),
            objects: it.objects.clone(),
            object_names: it.object_names.clone(),
        };
        surface.validate()?;
        Ok(surface)
    }
}

/// The values of all corners, each once, and the place of each corner's.
fn shared<const N: usize>(corners: &[[[f32; N]; 3]]) -> (Vec<f32>, Vec<u32>) {
    let mut known: BTreeMap<[u32; N], u32> = BTreeMap::new();
    let (mut values, mut places) = (Vec::new(), Vec::with_capacity(3 * corners.len()));
    for value in corners.iter().flatten() {
        let next = (values.len() / N) as u32;
        let place = *known.entry(value.map(f32::to_bits)).or_insert(next);
        if place == next {
            values.extend(value);
        }
        places.push(place);
    }
    (values, places)
}

/// The value of each corner.
fn own<const N: usize>(
    column: &'static str,
    values: &[f32],
    places: &[u32],
) -> Result<Vec<[[f32; N]; 3]>, AppearanceError> {
    whole(column, values.len(), N)?;
    whole(column, places.len(), 3)?;
    let values = values.as_chunks::<N>().0;
    let count = values.len();
    if let Some((corner, &index)) =
        places.iter().enumerate().find(|(_, place)| **place as usize >= count)
    {
        return Err(AppearanceError::Corner { corner, column, index, count });
    }
    let of = |places: &[u32; 3]| places.map(|place| values[place as usize]);
    Ok(places.as_chunks::<3>().0.iter().map(of).collect())
}

/// A column of tuples has no part of one.
fn whole(column: &'static str, length: usize, tuple: usize) -> Result<(), AppearanceError> {
    let wanted = length.div_ceil(tuple) * tuple;
    if length == wanted { Ok(()) } else { Err(AppearanceError::Column { column, length, wanted }) }
}

/// Wraps by their numbers.
const WRAPS: [TextureWrap; 3] = [TextureWrap::Repeat, TextureWrap::Mirror, TextureWrap::Clamp];

impl From<&SurfaceTexture> for AppearanceTexture {
    fn from(texture: &SurfaceTexture) -> Self {
        let TextureMapping { offset: [u, v], rotation, scale: [s, t], wrap } = texture.mapping;
        let number = |wrap| WRAPS.iter().position(|it| *it == wrap).unwrap_or(0) as u32;
        let straight = texture.mapping.is_straight();
        Self {
            name: texture.name.clone(),
            media_type: texture.media_type.clone(),
            offset: texture.offset,
            length: texture.length,
            transform: if straight { Vec::new() } else { vec![u, v, rotation, s, t] },
            wrap: if wrap == TextureMapping::default().wrap {
                Vec::new()
            } else {
                wrap.map(number).to_vec()
            },
        }
    }
}

/// What is not understood leaves coordinates as they are: a look decides nothing.
impl From<&AppearanceTexture> for TextureMapping {
    fn from(texture: &AppearanceTexture) -> Self {
        let known = |&number: &u32| WRAPS.get(number as usize).copied().unwrap_or_default();
        let wrap = match &texture.wrap[..] {
            [u, v] => [known(u), known(v)],
            _ => Default::default(),
        };
        match texture.transform[..] {
            [u, v, rotation, s, t] => Self { offset: [u, v], rotation, scale: [s, t], wrap },
            _ => Self { wrap, ..Self::default() },
        }
    }
}

impl From<&SurfaceMaterial> for AppearanceMaterial {
    fn from(material: &SurfaceMaterial) -> Self {
        let texture = material.texture.as_ref().map(AppearanceTexture::from);
        Self {
            name: material.name.clone(),
            base_colour: material.base_colour.to_vec(),
            metallic: material.metallic,
            roughness: material.roughness,
            texture,
        }
    }
}

impl From<&AppearanceMaterial> for SurfaceMaterial {
    fn from(material: &AppearanceMaterial) -> Self {
        let colour = |k: usize| material.base_colour.get(k).copied().unwrap_or(1.0);
        let texture = material.texture.as_ref().map(|texture| SurfaceTexture {
            name: texture.name.clone(),
            media_type: texture.media_type.clone(),
            offset: texture.offset,
            length: texture.length,
            mapping: TextureMapping::from(texture),
        });
        Self {
            name: material.name.clone(),
            base_colour: std::array::from_fn(colour),
            metallic: material.metallic,
            roughness: material.roughness,
            texture,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recorded;

    fn surface() -> SurfaceAttributes {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(0.1, -0.0, 1.0 / 3.0)];
        let mesh = TriMesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3]] };
        let picture = SurfaceTexture {
            name: "wood".to_owned(),
            media_type: "image/png".to_owned(),
            offset: 120,
            length: 4096,
            mapping: TextureMapping {
                offset: [0.25, 0.5],
                rotation: 0.75,
                scale: [2.0, -1.0],
                wrap: [TextureWrap::Mirror, TextureWrap::Clamp],
            },
        };
        let varnish = SurfaceMaterial { texture: Some(picture), ..SurfaceMaterial::named("oak") };
        SurfaceAttributes {
            mesh,
            uv: vec![[[0.0, 0.1], [0.5, 0.2], [0.0, 0.1]], [[0.5, 0.2], [1.0, 1.0], [0.0, 0.1]]],
            normals: vec![[[0.0, 0.0, 1.0]; 3], [[0.0, 0.0, 1.0]; 3]],
            slots: vec![1, 0],
            materials: vec![SurfaceMaterial::named("tin"), varnish],
            objects: vec![0, 1],
            object_names: vec!["lid".to_owned(), "box".to_owned()],
        }
    }

    #[test]
    fn a_surface_survives_and_equal_values_are_kept_once() {
        let appearance = Appearance::of(vec![3, 4], "scene/a.glb", &surface());
        assert_eq!((appearance.uv.len(), appearance.normals.len()), (6, 3));
        let read = Appearance::from_bytes(&appearance.to_bytes()).expect("decodes");
        assert_eq!(read, appearance);
        assert_eq!(SurfaceAttributes::try_from(&read), Ok(surface()));
    }

    #[test]
    fn damaged_columns_are_refused_by_name() {
        let good = Appearance::of(vec![3], "scene/a.glb", &surface());
        let refused = |change: fn(&mut Appearance)| {
            let mut bad = good.clone();
            change(&mut bad);
            SurfaceAttributes::try_from(&bad).expect_err("is damaged").to_string()
        };
        let said = refused(|it| it.uv.truncate(5));
        assert_eq!(said, "uv has 5 entries, 6 are needed");
        let said = refused(|it| it.normal_corner[2] = 7);
        assert_eq!(said, "corner 2 names entry 7 of the 1 in normals");
        let said = refused(|it| it.slots[1] = 2);
        assert_eq!(said, "triangle 1 names material 2 of 2");
        let said = refused(|it| it.triangles[0] = 4);
        assert!(said.contains("triangle 0 uses vertex 4"), "{said}");
    }
}
