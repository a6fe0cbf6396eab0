//! What bodies look like: the artist's surface. It decides nothing.

use super::{APPEARANCE, RecordError, Recorder, Recording};
use cullet_geometry::attributes::{AttributeTransfer, SkinTriangle, SurfaceAttributes};
use cullet_geometry::{Solid, Surface, Vec3};
use cullet_proto::recording::{Appearance, AppearanceTexture};

impl Recorder {
    /// Records what bodies look like, from the mesh file that is attached under `file`.
    ///
    /// # Errors
    /// A body that is not recorded, or a file that cannot be written.
    pub fn appearance(
        &mut self,
        bodies: Vec<u64>,
        file: &str,
        surface: &SurfaceAttributes,
    ) -> Result<(), RecordError> {
        if let Some(&body) = bodies.iter().find(|body| !self.bodies.contains_key(body)) {
            return Err(RecordError::UnknownBody { body, what: "appearance" });
        }
        let message = Appearance::of(bodies, file, surface);
        self.sink.own(APPEARANCE, self.stamp(), &message).map(|_| ())
    }
}

impl Recording {
    /// The surface of the mesh file that a body of the scene was made of, in the frame that the
    /// body had at its birth \[m\]; nothing for a body whose file has no more than a shape, or that
    /// has none.
    ///
    /// # Errors
    /// [`RecordError::Appearance`] for one that is damaged.
    pub fn appearance_of(&self, root: u64) -> Result<Option<SurfaceAttributes>, RecordError> {
        let Some(appearance) = self.appearances.iter().find(|it| it.bodies.contains(&root)) else {
            return Ok(None);
        };
        let surface = SurfaceAttributes::try_from(appearance);
        surface.map(Some).map_err(|source| RecordError::Appearance { body: root, source })
    }

    /// The bytes of a picture of an appearance, if it lies in its mesh file, or is recorded as a
    /// file beside that.
    #[must_use]
    pub fn picture(&self, of: &Appearance, texture: &AppearanceTexture) -> Option<&[u8]> {
        if texture.length == 0 {
            let folder = of.file.rfind('/').map_or("", |at| &of.file[..=at]);
            let beside = self.attachments.get(&format!("{folder}{}", texture.name));
            return beside.map(Vec::as_slice).filter(|bytes| !bytes.is_empty());
        }
        let file = self.attachments.get(&of.file)?;
        let start = usize::try_from(texture.offset).ok()?;
        let end = start.checked_add(usize::try_from(texture.length).ok()?)?;
        file.get(start..end).filter(|bytes| !bytes.is_empty())
    }
}

/// The skin of a body, all but its crack faces, with the attributes of the artist's surface:
/// `solid` in its own frame, whose origin was at `place` \[m\]. [`SkinTriangle::of`] is a triangle
/// of the solid; corners are in the body's own frame.
#[must_use]
pub fn skin_of(transfer: &AttributeTransfer<'_>, solid: &Solid, place: Vec3) -> Vec<SkinTriangle> {
    let outer = |t: &usize| solid.surface[*t] == Surface::Outer;
    let kept: Vec<usize> = (0..solid.surface.len()).filter(outer).collect();
    let at_rest = |&t: &usize| solid.mesh.corners(t).map(|p| p + place);
    let corners: Vec<[Vec3; 3]> = kept.iter().map(at_rest).collect();
    let mut skin = transfer.transfer(&corners);
    for triangle in &mut skin {
        let whole = triangle.corners == corners[triangle.of];
        triangle.of = kept[triangle.of];
        triangle.corners = if whole {
            // To the last bit: the fragment stays closed.
            solid.mesh.corners(triangle.of)
        } else {
            triangle.corners.map(|p| p - place)
        };
    }
    skin
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{block, half, meta};
    use super::*;
    use cullet_geometry::attributes::{SurfaceMaterial, SurfaceTexture};
    use cullet_proto::recording::Body;

    /// The surface of a block: a material for its lower half in z, one for its upper.
    fn surface(solid: &Solid) -> SurfaceAttributes {
        let picture = SurfaceTexture { offset: 3, length: 4, ..SurfaceTexture::default() };
        let mut materials = ["low", "high"].map(SurfaceMaterial::named).to_vec();
        materials[1].texture = Some(picture);
        let upper = |t: usize| solid.mesh.corners(t).iter().all(|p| p.z > 0.0);
        let slots = (0..solid.mesh.triangles.len()).map(|t| u32::from(upper(t))).collect();
        let mesh = solid.mesh.clone();
        SurfaceAttributes { mesh, slots, materials, ..SurfaceAttributes::default() }
    }

    /// A block with an appearance, half of which is a body later.
    fn recorded() -> Recording {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        let mut recorder = Recorder::create(&path, &meta()).expect("creates");
        let parts = [(block(2.0 * half(), 0.0), None), (block(half(), 1.0), Some(4))];
        for ((solid, parent), id) in parts.iter().zip([4, 9]) {
            let geometry = recorder.geometry(solid).expect("writes").to_vec();
            let body = Body { id, parent: *parent, geometry, ..Body::default() };
            recorder.body(&body).expect("writes");
        }
        let look = surface(&parts[0].0);
        recorder.appearance(vec![4], "note.txt", &look).expect("writes");
        let early = recorder.appearance(vec![5], "note.txt", &look).expect_err("no such body");
        assert_eq!(early.to_string(), "body 5 was not recorded before its appearance");
        recorder.finish(10, 0.2).expect("ends");
        Recording::open(&path).expect("opens")
    }

    #[test]
    fn an_appearance_is_read_back_and_found_on_a_part() {
        let recording = recorded();
        let surface = recording.appearance_of(4).expect("is sound").expect("is there");
        assert_eq!(recording.appearance_of(9).expect("is sound"), None, "a root's only");
        let place = Vec3::new(0.0, 0.0, half().z);
        let body = recording.body(9).expect("the part").clone();
        let solid = recording.mesh(&body).expect("its mesh");
        let skin = skin_of(&AttributeTransfer::new(&surface), &solid, place);
        let cracked = |of: usize| solid.surface[of].is_crack();
        assert!(skin.iter().all(|it| !cracked(it.of)), "crack faces are no skin");
        // The part's top lies on that of the block.
        let top = |it: &&SkinTriangle| it.corners.iter().all(|p| p.z > 0.9 * half().z);
        assert!(skin.iter().filter(top).count() > 0);
        assert!(skin.iter().filter(top).all(|it| it.slot == 1));
        let whole = |it: &&SkinTriangle| it.corners == solid.mesh.corners(it.of);
        assert!(skin.iter().any(|it| whole(&it)), "to the last bit where it was not divided");
    }

    #[test]
    fn a_picture_is_a_range_of_its_mesh_file() {
        let recording = recorded();
        let look = &recording.appearances[0];
        let texture = look.materials[1].texture.clone().expect("a picture");
        assert_eq!(recording.picture(look, &texture), Some(&b"hand"[..]));
        let beyond = AppearanceTexture { length: 99, ..texture.clone() };
        assert_eq!(recording.picture(look, &beyond), None);
        let elsewhere = AppearanceTexture { length: 0, ..texture };
        assert_eq!(recording.picture(look, &elsewhere), None);
        let beside = AppearanceTexture { name: "note.txt".to_owned(), ..elsewhere };
        assert_eq!(
            recording.picture(look, &beside),
            recording.attachments.get("note.txt").map(|x| &x[..])
        );
    }

    #[test]
    fn a_damaged_appearance_is_an_error_that_names_its_body() {
        let mut recording = recorded();
        recording.appearances[0].slots[2] = 7;
        let told = recording.appearance_of(4).expect_err("is damaged").to_string();
        assert_eq!(told, "the appearance of body 4: triangle 2 names material 7 of 2");
    }
}
