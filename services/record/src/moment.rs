//! A recording at one moment: which bodies there are, where they are, and their meshes.

use super::{PoseRow, RecordError, Recording};
use cullet_geometry::Solid;
use cullet_proto::recording::{Body, EventKind};
use std::collections::BTreeMap;

impl Recording {
    /// The body with this number.
    #[must_use]
    pub fn body(&self, id: u64) -> Option<&Body> {
        self.bodies.iter().find(|body| body.id == id)
    }

    /// The mesh of a body in its own frame \[m\], whose origin is the centre of mass; every
    /// triangle says whether it is a crack face.
    ///
    /// # Errors
    /// [`RecordError::Geometry`] for a mesh that is damaged, [`RecordError::UnknownGeometry`] for
    /// one that is not in the recording.
    pub fn mesh(&self, body: &Body) -> Result<Solid, RecordError> {
        let unknown = RecordError::UnknownGeometry { body: body.id };
        let geometry = self.geometries.get(&body.geometry).ok_or(unknown)?;
        Solid::try_from(geometry).map_err(|source| RecordError::Geometry { body: body.id, source })
    }

    /// The bodies that are there at a time \[s\], by number, and where they were at the last
    /// recorded step up to it. Those that broke or left by then are not among them.
    #[must_use]
    pub fn poses_at(&self, time: f64) -> Vec<PoseRow> {
        let mut there: BTreeMap<u64, PoseRow> = BTreeMap::new();
        for poses in self.poses.iter().take_while(|poses| poses.time <= time) {
            there.extend(PoseRow::of(poses).map(|row| (row.id, row)));
        }
        for event in self.events.iter().take_while(|event| event.time <= time) {
            if let (EventKind::Fractured | EventKind::Removed, Some(gone)) =
                (event.kind(), event.body)
            {
                there.remove(&gone);
            }
        }
        there.into_values().collect()
    }
}
