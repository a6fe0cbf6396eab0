//! A recording played back: what there is after each step of the world.

use cullet_geometry::{Mat3, Quat, Solid, Vec3};
use cullet_proto::recording::{Body, BodyPoses, EventKind, Grains};
use cullet_record::Recording;
use std::collections::{BTreeMap, BTreeSet};

/// Where a part is and how it moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartMotion {
    pub(super) at: Vec3,
    pub(super) turn: Quat,
    pub(super) velocity: Vec3,
    pub(super) spin: Vec3,
}

/// A body, a fragment or a grain.
#[derive(Clone, Debug)]
pub(super) struct RecordedPart {
    /// The body of the scene that it is of.
    pub(super) object: String,
    pub(super) mass: f64,
    pub(super) volume: f64,
    /// About its own centre of mass, in its own frame \[kg·m²\].
    inertia: Mat3,
    pub(super) fixed: bool,
    pub(super) grain: bool,
    /// Whether it is a body of the scene, not a part of one.
    pub(super) whole: bool,
    there: bool,
    row: Option<PartMotion>,
    /// Where it was first.
    pub(super) first: Option<Vec3>,
}

impl RecordedPart {
    /// Where it is, if it is there.
    pub(super) fn row(&self) -> Option<&PartMotion> {
        self.row.as_ref().filter(|_| self.there)
    }

    /// Inertia about its own centre of mass in the world's frame \[kg·m²\].
    pub(super) fn inertia(&self, row: &PartMotion) -> Mat3 {
        let turn = row.turn.to_rotation_matrix();
        turn.matrix() * self.inertia * turn.matrix().transpose()
    }

    fn put(&mut self, row: PartMotion) {
        self.row = Some(row);
        self.first.get_or_insert(row.at);
    }
}

/// All parts of a recording at the step to which it was replayed.
pub(super) struct ReplayState<'a> {
    recording: &'a Recording,
    pub(super) gravity: Vec3,
    bodies: BTreeMap<u64, RecordedPart>,
    grains: BTreeMap<u64, RecordedPart>,
    /// How many of the recording's lists are played.
    born: usize,
    posed: usize,
    strewn: usize,
    told: usize,
    shaped: usize,
}

impl<'a> ReplayState<'a> {
    /// Before the first step.
    pub(super) fn new(recording: &'a Recording) -> Self {
        let gravity = recording.meta.get("gravity").map(String::as_str).unwrap_or_default();
        let mut g = gravity.split_whitespace().map(|text| text.parse().unwrap_or(f64::NAN));
        let mut next = || g.next().unwrap_or(f64::NAN);
        let gravity = Vec3::new(next(), next(), next());
        Self {
            recording,
            gravity,
            bodies: BTreeMap::new(),
            grains: BTreeMap::new(),
            born: 0,
            posed: 0,
            strewn: 0,
            told: 0,
            shaped: 0,
        }
    }

    /// Plays all up to the end of a step.
    pub(super) fn play(&mut self, step: u64) {
        let recording = self.recording;
        while let Some(body) = recording.bodies.get(self.born).filter(|b| b.birth_step <= step) {
            self.bodies.insert(body.id, part(recording, body));
            self.born += 1;
        }
        while let Some(event) = recording.events.get(self.told).filter(|e| e.step <= step) {
            if matches!(event.kind(), EventKind::Fractured | EventKind::Removed)
                && let Some(gone) = event.body.and_then(|body| self.bodies.get_mut(&body))
            {
                gone.there = false;
            }
            self.told += 1;
        }
        while let Some(shape) = recording.shapes.get(self.shaped).filter(|s| s.step <= step) {
            if let Some(part) = self.bodies.get_mut(&shape.body) {
                (part.mass, part.volume) = (shape.mass, shape.volume);
                part.inertia = inertia(recording, &shape.geometry) * (shape.mass / shape.volume);
            }
            self.shaped += 1;
        }
        while let Some(poses) = recording.poses.get(self.posed).filter(|p| p.step <= step) {
            self.pose(poses);
            self.posed += 1;
        }
        while let Some(grains) = recording.debris.get(self.strewn).filter(|g| g.step <= step) {
            self.strew(grains);
            self.strewn += 1;
        }
    }

    fn pose(&mut self, poses: &BodyPoses) {
        let (at, turn) = (poses.positions.as_chunks::<3>().0, poses.rotations.as_chunks::<4>().0);
        let (velocity, spin) =
            (poses.velocities.as_chunks::<3>().0, poses.spins.as_chunks::<3>().0);
        let rows = at.iter().zip(turn).zip(velocity.iter().zip(spin));
        for (id, ((at, [x, y, z, w]), (velocity, spin))) in poses.ids.iter().zip(rows) {
            if let Some(part) = self.bodies.get_mut(id) {
                let turn = nalgebra::Quaternion::new(*w, *x, *y, *z);
                part.put(PartMotion {
                    at: Vec3::from(*at),
                    // As recorded: a unit quaternion bit for bit.
                    turn: Quat::new_unchecked(turn),
                    velocity: Vec3::from(*velocity),
                    spin: Vec3::from(*spin),
                });
            }
        }
    }

    fn strew(&mut self, grains: &Grains) {
        let (at, velocity) =
            (grains.positions.as_chunks::<3>().0, grains.velocities.as_chunks::<3>().0);
        for (k, (id, (at, velocity))) in grains.ids.iter().zip(at.iter().zip(velocity)).enumerate()
        {
            if let (Some(mass), Some(parent)) = (grains.masses.get(k), grains.parents.get(k)) {
                let Some(parent) = self.bodies.get(parent) else { continue };
                let volume = mass / parent.mass * parent.volume;
                let part = RecordedPart {
                    mass: *mass,
                    volume,
                    inertia: Mat3::zeros(),
                    grain: true,
                    whole: false,
                    there: true,
                    row: None,
                    first: None,
                    ..parent.clone()
                };
                self.grains.insert(*id, part);
            }
            if let Some(part) = self.grains.get_mut(id) {
                let (turn, spin) = (Quat::identity(), Vec3::zeros());
                part.put(PartMotion {
                    at: Vec3::from(*at),
                    turn,
                    velocity: Vec3::from(*velocity),
                    spin,
                });
            }
        }
    }

    /// What is there of these bodies of the scene; of all that are not fixed without any.
    pub(super) fn parts<'s>(
        &'s self,
        bodies: Option<&'s BTreeSet<String>>,
    ) -> impl Iterator<Item = (&'s RecordedPart, &'s PartMotion)> {
        let wanted = move |part: &&RecordedPart| match bodies {
            Some(names) => names.contains(&part.object),
            None => !part.fixed,
        };
        let all = self.bodies.values().chain(self.grains.values()).filter(wanted);
        all.filter_map(|part| Some((part, part.row()?)))
    }
}

/// Of a solid over its density \[m⁵\].
fn inertia(recording: &Recording, geometry: &[u8]) -> Mat3 {
    let solid = recording.geometries.get(geometry).and_then(|g| Solid::try_from(g).ok());
    solid.map_or_else(Mat3::zeros, |solid| solid.mesh.mass_properties().inertia)
}

fn part(recording: &Recording, body: &Body) -> RecordedPart {
    RecordedPart {
        object: body.object.clone(),
        mass: body.mass,
        volume: body.volume,
        inertia: inertia(recording, &body.geometry) * (body.mass / body.volume),
        fixed: body.fixed,
        grain: false,
        whole: body.parent.is_none(),
        there: true,
        row: None,
        first: None,
    }
}
