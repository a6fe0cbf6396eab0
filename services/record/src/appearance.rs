//! What bodies look like: the artist's surface, and where fragments lay in it. None of it decides.

use super::{APPEARANCE, REST, RecordError, Recorder, Recording};
use cullet_geometry::attributes::{AttributeTransfer, SkinTriangle, SurfaceAttributes};
use cullet_geometry::{Solid, Surface, Vec3};
use cullet_proto::recording::{Appearance, AppearanceTexture, RestPlaces};

/// Where the frame of a body lies in that of the body of the scene that it comes from, before
/// anything moved. Axes are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestPlace {
    /// The body of the scene.
    pub root: u64,
    /// The origin of the body in the frame of `root` at its birth \[m\].
    pub origin: Vec3,
}

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

    /// Records where bodies lay in those of the scene that they come from, before anything moved.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn rest_places(
        &mut self,
        (step, time): (u64, f64),
        places: &[(u64, RestPlace)],
    ) -> Result<(), RecordError> {
        let mut message = RestPlaces { step, time, ..RestPlaces::default() };
        for (body, place) in places {
            message.bodies.push(*body);
            message.roots.push(place.root);
            message.origins.extend(place.origin.iter());
        }
        self.sink.own(REST, self.stamp(), &message).map(|_| ())
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

    /// The bytes of a picture of an appearance, if it lies in its mesh file.
    #[must_use]
    pub fn picture(&self, of: &Appearance, texture: &AppearanceTexture) -> Option<&[u8]> {
        let file = self.attachments.get(&of.file)?;
        let start = usize::try_from(texture.offset).ok()?;
        let end = start.checked_add(usize::try_from(texture.length).ok()?)?;
        file.get(start..end).filter(|bytes| !bytes.is_empty())
    }

    /// Where a body lay in the body of the scene that it comes from, as last recorded; nothing for
    /// a fragment of a recording that does not tell, as old ones do not.
    #[must_use]
    pub fn rest_place(&self, body: u64) -> Option<RestPlace> {
        for places in self.rest_places.iter().rev() {
            if let Some(k) = places.bodies.iter().position(|it| *it == body) {
                let origin = places.origins.get(3 * k..3 * k + 3)?;
                let origin = Vec3::new(origin[0], origin[1], origin[2]);
                return Some(RestPlace { root: *places.roots.get(k)?, origin });
            }
        }
        let born = self.body(body)?;
        born.parent.is_none().then_some(RestPlace { root: body, origin: Vec3::zeros() })
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
