//! A picture of solids that are in no recording: for galleries.

use super::camera::Camera;
use super::letters::Typeface;
use super::picture::Picture;
use super::reel::Reel;
use super::stage::Focus;
use super::track::{Actor, Mesh, Track};
use cullet_geometry::{Pose, Solid, Vec3};
use cullet_record::palette;
use std::sync::Arc;

/// Height of the caption's line.
const CAPTION: usize = 20;

/// Draws solids where they are put, in the colours of a material, with z upward, standing on a
/// floor at the lowest of them; seen along `forward`.
#[must_use]
pub fn exhibit(
    pieces: &[(Solid, Pose)],
    material: &str,
    forward: Vec3,
    size: (usize, usize),
    caption: &str,
) -> Picture {
    let (outer, inner) = palette::colours(material, material, 0);
    let actor = |(id, (solid, pose)): (u64, &(Solid, Pose))| Actor {
        id,
        object: material.to_owned(),
        share: None,
        fragment: true,
        deformed: false,
        fixed: false,
        outer,
        inner,
        mesh: Arc::new(Mesh::of(solid)),
        rows: vec![(0.0, *pose)],
        velocities: vec![Vec3::zeros()],
        end: f64::INFINITY,
    };
    let actors = (0..).zip(pieces).map(actor).collect();
    let track = Track { actors, ..Track::empty(1.0, Vec3::z()) };
    let corners: Vec<Vec3> = track.present(0.0).flat_map(|(_, a, pose)| a.corners(pose)).collect();
    let (low, high) = cullet_geometry::mesh::bounds(&corners).unwrap_or_default();
    let focus = Focus {
        camera: Camera::fit(&corners, forward, Vec3::z(), size),
        target: 0.5 * (low + high),
        reach: 0.5 * (high - low).norm(),
        floor: Some(low.z),
    };
    let mut picture = Reel::new(&track, &focus, size).draw(0.0);
    picture.caption(caption, Typeface::of_height(CAPTION));
    picture
}
