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

#[cfg(test)]
mod tests {
    use super::super::synthetic::{self, BREAK, STEP};
    use super::super::{RecordError, Recording};

    fn split() -> Recording {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        synthetic::run(&path, &synthetic::meta()).expect("a recording");
        Recording::open(&path).expect("it reads")
    }

    #[test]
    fn bodies_are_there_from_their_first_pose_until_they_break() {
        let recording = split();
        let there =
            |time: f64| -> Vec<u64> { recording.poses_at(time).iter().map(|row| row.id).collect() };
        let breaks = BREAK as f64 * STEP;
        assert_eq!(there(-1.0), [0; 0]);
        assert_eq!(there(0.0), [0, 1]);
        assert_eq!(there(breaks - 0.5 * STEP), [0, 1]);
        assert_eq!(there(breaks), [0, 2, 3]);
        assert_eq!(there(f64::INFINITY), [0, 2, 3]);
        // Between steps a body is where it was at the last one.
        let height = |time: f64| recording.poses_at(time)[1].pose.translation.z;
        let fallen = |steps: f64| 0.9 - 0.5 * 9.81 * (steps * STEP).powi(2);
        assert!((height(10.9 * STEP) - fallen(10.0)).abs() < 1e-12, "{}", height(10.9 * STEP));
    }

    #[test]
    fn a_mesh_is_the_body_or_an_error_that_names_it() {
        let mut recording = split();
        let cube = recording.body(1).expect("the cube").clone();
        let mesh = recording.mesh(&cube).expect("its mesh");
        assert!((mesh.volume() - cube.volume).abs() < 1e-12, "{} m³", mesh.volume());
        assert!(recording.body(9).is_none());
        let geometry = recording.geometries.get_mut(&cube.geometry).expect("its geometry");
        geometry.vertices[0] += 1e-9;
        let damaged = recording.mesh(&cube).expect_err("it is another mesh");
        assert!(matches!(damaged, RecordError::Geometry { body: 1, .. }), "{damaged}");
        recording.geometries.clear();
        let lost = recording.mesh(&cube).expect_err("it is gone");
        assert!(matches!(lost, RecordError::UnknownGeometry { body: 1 }), "{lost}");
    }
}
