//! A recording as a film has it: who is there from when to when, and where at which frame.

use crate::error::ExportError;
use crate::looks::{ObjectLook, object_look};
use crate::moving::{ExportWindow, MovingTrack, tracks, windows};
use crate::names::UniqueNames;
use crate::pictures::{ArtistMaterial, ExportPicture, PictureShelf};
use crate::sheets::{CrackSheet, sheet_mesh};
use crate::surface::{ArtistSurface, ExportMesh};
use cullet_geometry::attributes::SurfaceAttributes;
use cullet_geometry::{Pose, Quat, Sheet, Solid, Vec3};
use cullet_proto::recording::{Body, EventKind};
use cullet_record::{FragmentOrigin, InteriorLook, PoseRow, RecordError, Recording};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Times closer than this are one \[s\].
const SAME: f64 = 1e-9;
/// A body that turns by more than this between two frames gets samples between them \[rad\]:
/// programs turn it the short way.
const TURN_OF_A_FRAME: f64 = std::f64::consts::FRAC_PI_2;

/// What a file shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scenery {
    /// The whole range, moving.
    Motion,
    /// One moment \[s\], still.
    Moment(f64),
    /// Pieces in their places in the whole object.
    Rest,
}

/// Which part of a run is exported, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameRange {
    /// The first moment \[s\].
    pub(crate) start: f64,
    /// The last one \[s\].
    pub(crate) end: f64,
    /// Frames a second \[1/s\].
    pub(crate) fps: f64,
    /// Time between samples: a frame, or a step of the run where that is longer \[s\].
    interval: f64,
    /// Time step of the run \[s\].
    step: f64,
}

/// A body of one shape, from birth to end.
#[derive(Clone, Debug)]
pub(crate) struct BodyTrack {
    /// As it was recorded; mass, volume and geometry are those of this shape.
    pub(crate) body: Body,
    /// A name that is an identifier and that no other body has.
    pub(crate) name: String,
    /// When it appears \[s\].
    pub(crate) birth: f64,
    /// When it breaks, leaves or takes another shape \[s\].
    pub(crate) death: f64,
    /// Where it is in the whole object.
    pub(crate) rest: Pose,
    /// Where it comes from; `None` where that is not known.
    pub(crate) origin: Option<FragmentOrigin>,
    /// Whether it broke.
    pub(crate) broke: bool,
    /// Which of the meshes it has: the digest of its geometry, and, where the artist's mesh has
    /// more than a shape, its number, for that depends on the place in the object.
    pub(crate) mesh: Vec<u8>,
    /// Cracks that end inside it.
    pub(crate) sheets: Vec<CrackSheet>,
    rows: Vec<(f64, PoseRow)>,
}

impl BodyTrack {
    /// Whether it comes from there; `None` where that is not known.
    pub(crate) fn is_of(&self, origin: FragmentOrigin) -> Option<bool> {
        self.origin.map(|own| own == origin)
    }
}

/// A grain of debris from birth on.
#[derive(Clone, Debug)]
pub(crate) struct GrainTrack {
    pub(crate) id: u64,
    /// The body that it broke from.
    pub(crate) parent: u64,
    /// Name of the object that this is a part of.
    pub(crate) object: String,
    /// Name of the material.
    pub(crate) material: String,
    /// Mass \[kg\].
    pub(crate) mass: f64,
    /// Diameter \[m\]; a program that wants a radius takes half of it.
    pub(crate) size: f64,
    /// When it appears \[s\].
    pub(crate) birth: f64,
    /// When, where and how fast it was \[s, m, m/s\].
    rows: Vec<(f64, Vec3, Vec3)>,
}

/// A run from which every writer writes. Up is z.
#[derive(Clone, Debug)]
pub(crate) struct ExportTimeline {
    /// Name of the scene.
    pub(crate) scene: String,
    pub(crate) range: FrameRange,
    /// What objects look like inside, where the scene says so.
    pub(crate) interiors: BTreeMap<String, InteriorLook>,
    /// In order of birth.
    pub(crate) bodies: Vec<BodyTrack>,
    pub(crate) grains: Vec<GrainTrack>,
    /// Sheets, that is bodies that move as they deform.
    pub(crate) moving: Vec<MovingTrack>,
    /// Windows of their time.
    pub(crate) windows: Vec<ExportWindow>,
    /// Meshes by [`BodyTrack::mesh`].
    pub(crate) meshes: BTreeMap<Vec<u8>, ExportMesh>,
    /// Pictures of the materials of artists' meshes.
    pub(crate) pictures: Vec<Arc<ExportPicture>>,
    /// Those that cannot be written, in words.
    pub(crate) pictures_left_out: Vec<String>,
}

impl FrameRange {
    /// Frames from the first to the last.
    pub(crate) fn frames(&self) -> usize {
        ((self.end - self.start) * self.fps + SAME).floor() as usize + 1
    }

    /// Time of a moment in the file \[s\].
    pub(crate) fn since(&self, time: f64) -> f64 {
        (time - self.start).max(0.0)
    }

    /// Time of a sample \[s\]. Whole multiples, not sums: frames fall where they are meant to.
    fn sample(&self, k: usize) -> f64 {
        match self.interval * self.fps {
            one if (one - 1.0).abs() < SAME => self.start + k as f64 / self.fps,
            _ => self.start + k as f64 * self.interval,
        }
    }

    /// The first sample that is not before a time \[s\].
    fn sample_from(&self, time: f64) -> f64 {
        self.sample(((time - self.start) / self.interval - SAME).ceil().max(0.0) as usize)
    }

    /// A stretch of time in samples: its ends and the frames between.
    fn samples(&self, from: f64, to: f64) -> Vec<f64> {
        let (from, to) = (from.max(self.start), to.min(self.end));
        let mut times = vec![from];
        let first = ((from - self.start) / self.interval).floor().max(0.0) as usize;
        let frames = (first..).map(|k| self.sample(k)).skip_while(|&t| t <= from + SAME);
        times.extend(frames.take_while(|&t| t < to - SAME));
        if to > from + SAME {
            times.push(to);
        }
        times
    }
}

/// Which of two rows holds at a time, and how far the way to the next has gone \[1\]. Rows that
/// did not change are not recorded: a body rests until a step before its next row.
fn between(count: usize, at: impl Fn(usize) -> f64, time: f64, step: f64) -> (usize, f64) {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = low.midpoint(high);
        if at(middle) <= time { low = middle + 1 } else { high = middle }
    }
    let last = low.saturating_sub(1);
    if low == 0 || low >= count {
        return (last, 0.0);
    }
    let leaves = at(last).max(at(low) - step);
    (last, ((time - leaves) / (at(low) - leaves)).clamp(0.0, 1.0))
}

impl BodyTrack {
    /// Where it is \[m\], with its velocity \[m/s\] and spin \[rad/s\]. Between recorded steps it
    /// moves evenly.
    pub(crate) fn at(&self, time: f64, range: &FrameRange) -> PoseRow {
        let (k, share) = between(self.rows.len(), |k| self.rows[k].0, time, range.step);
        let row = self.rows[k].1;
        if share <= 0.0 {
            return row;
        }
        let next = self.rows[k + 1].1;
        let place = row.pose.translation.vector.lerp(&next.pose.translation.vector, share);
        let turn = row.pose.rotation.slerp(&next.pose.rotation, share);
        PoseRow {
            id: row.id,
            pose: Pose::from_parts(place.into(), turn),
            velocity: row.velocity.lerp(&next.velocity, share),
            spin: row.spin.lerp(&next.spin, share),
        }
    }

    /// Whether it is there at some moment of a range.
    pub(crate) fn appears(&self, range: &FrameRange) -> bool {
        self.birth <= range.end && self.death > range.start
    }

    /// Whether it is there at a time \[s\].
    pub(crate) fn is_there(&self, time: f64) -> bool {
        self.birth <= time && time < self.death
    }

    /// When it has to be looked at: at the ends of its life, at each frame, and so often that it
    /// never turns by more than a quarter between two times.
    pub(crate) fn samples(&self, range: &FrameRange) -> Vec<f64> {
        let frames = range.samples(self.birth, self.death);
        let mut times = Vec::with_capacity(frames.len());
        for pair in frames.windows(2) {
            let (from, span) = (pair[0], pair[1] - pair[0]);
            let turned = self.at(from, range).spin.norm() * span;
            let most = (span / range.step).floor().max(1.0);
            let parts = (turned / TURN_OF_A_FRAME).ceil().clamp(1.0, most) as usize;
            times.extend((0..parts).map(|k| from + span * k as f64 / parts as f64));
        }
        times.extend(frames.last());
        times
    }
}

impl GrainTrack {
    /// Where it is \[m\], and its velocity \[m/s\].
    pub(crate) fn at(&self, time: f64, range: &FrameRange) -> (Vec3, Vec3) {
        let (k, share) = between(self.rows.len(), |k| self.rows[k].0, time, range.step);
        let (_, place, velocity) = self.rows[k];
        match self.rows.get(k + 1) {
            Some((_, next, faster)) if share > 0.0 => {
                (place.lerp(next, share), velocity.lerp(faster, share))
            }
            Some(_) => (place, velocity),
            // It lies where it fell.
            None if time > self.rows[k].0 + range.step => (place, Vec3::zeros()),
            None => (place, velocity),
        }
    }

    /// When it has to be looked at: from its birth to the first sample at which it lies, so that
    /// grains are looked at together though each comes to rest at a time of its own.
    pub(crate) fn samples(&self, range: &FrameRange) -> Vec<f64> {
        let last = self.rows.last().map_or(self.birth, |row| row.0);
        range.samples(self.birth, range.sample_from(last.max(self.birth)))
    }
}

/// What a recording is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimelineOptions {
    pub(crate) fps: f64,
    pub(crate) start: Option<f64>,
    pub(crate) end: Option<f64>,
    pub(crate) grains: bool,
}

/// The turn that makes up z, as the viewers' frame `upright` of a recording has it.
fn upright(recording: &Recording) -> Quat {
    let gravity = recording.meta.get("gravity").map_or("", String::as_str);
    let numbers: Vec<f64> = gravity.split_whitespace().filter_map(|n| n.parse().ok()).collect();
    let up = match numbers[..] {
        [x, y, z] => (-Vec3::new(x, y, z)).try_normalize(1e-12).unwrap_or_else(Vec3::z),
        _ => Vec3::z(),
    };
    Quat::rotation_between(&up, &Vec3::z())
        .unwrap_or_else(|| Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI))
}

fn range(recording: &Recording, wanted: &TimelineOptions) -> Result<FrameRange, ExportError> {
    let whole = recording.poses.last().map_or(0.0, |poses| poses.time);
    let events = recording.events.iter().map(|event| event.time);
    let frames = recording.sheet_frames.iter().map(|frame| frame.time);
    let whole = events.chain(frames).fold(whole, f64::max);
    let step = recording.meta.get("step").and_then(|s| s.parse().ok());
    let step: f64 = step.filter(|s: &f64| s.is_finite() && *s > 0.0).unwrap_or(1.0 / wanted.fps);
    let (start, end) = (wanted.start.unwrap_or(0.0), wanted.end.unwrap_or(whole));
    if !(0.0..=whole).contains(&start) || !(start..=whole + SAME).contains(&end) {
        return Err(ExportError::Range { start, end, whole });
    }
    let interval = step.max(1.0 / wanted.fps);
    Ok(FrameRange { start, end: end.min(whole), fps: wanted.fps, interval, step })
}

impl ExportTimeline {
    /// What an object of a material looks like.
    pub(crate) fn look(&self, material: &str, object: &str, fixed: bool) -> ObjectLook {
        object_look(material, object, fixed, self.interiors.get(object))
    }

    pub(crate) fn of(recording: &Recording, wanted: &TimelineOptions) -> Result<Self, ExportError> {
        let range = range(recording, wanted)?;
        let up = upright(recording);
        let mut timeline = Self {
            scene: recording.meta.get("scene").cloned().unwrap_or_default(),
            range,
            interiors: recording.interiors(),
            bodies: bodies(recording, up),
            grains: Vec::new(),
            moving: Vec::new(),
            windows: windows(recording, [range.start, range.end])?,
            meshes: BTreeMap::new(),
            pictures: Vec::new(),
            pictures_left_out: Vec::new(),
        };
        timeline.bodies.retain(|track| !track.rows.is_empty() && track.appears(&range));
        let mut names = UniqueNames::default();
        for track in &mut timeline.bodies {
            track.name = names.give(&track.body.name);
        }
        timeline.add_sheets(recording, &mut names)?;
        timeline.moving = tracks(recording, up, [range.start, range.end], &mut names)?;
        timeline.add_meshes(recording)?;
        if wanted.grains {
            timeline.grains = grains(recording, up, &range);
        }
        Ok(timeline)
    }

    /// Adds to each body its cracks.
    fn add_sheets(
        &mut self,
        recording: &Recording,
        names: &mut UniqueNames,
    ) -> Result<(), ExportError> {
        for cracks in recording.cracks.iter().filter(|cracks| cracks.time <= self.range.end) {
            let (body, time) = (cracks.body, cracks.time);
            let there = |track: &&mut BodyTrack| {
                track.body.id == body && track.birth <= time + SAME && time < track.death
            };
            // It broke or left at once, or before what is exported.
            let Some(track) = self.bodies.iter_mut().find(there) else { continue };
            let sheet = Sheet::try_from(cracks);
            let sheet = sheet.map_err(|source| RecordError::Cracks { body, source })?;
            let name = names.give(&format!("{}_open_crack", track.name));
            let birth = time.max(track.birth);
            track.sheets.push(CrackSheet { name, birth, mesh: sheet_mesh(&sheet, body) });
        }
        Ok(())
    }

    /// Makes the mesh of each body.
    fn add_meshes(&mut self, recording: &Recording) -> Result<(), ExportError> {
        let mut surfaces: BTreeMap<u64, (SurfaceAttributes, Vec<ArtistMaterial>)> = BTreeMap::new();
        let mut shelf = PictureShelf::default();
        let places = recording.rest_places();
        for root in places.values().map(|place| place.root).collect::<BTreeSet<_>>() {
            let own = recording.appearances.iter().find(|it| it.bodies.contains(&root));
            if let Some((own, surface)) = own.zip(recording.appearance_of(root)?) {
                let materials = shelf.materials(recording, own, &surface);
                surfaces.insert(root, (surface, materials));
            }
        }
        (self.pictures, self.pictures_left_out) = shelf.finish();
        let artists: BTreeMap<u64, ArtistSurface<'_>> = surfaces
            .iter()
            .map(|(&root, (surface, own))| (root, ArtistSurface::new(surface, own.clone())))
            .collect();
        for track in &mut self.bodies {
            let (hash, body) = (&track.body.geometry, track.body.id);
            let artist = places.get(&body).and_then(|at| Some((artists.get(&at.root)?, at.origin)));
            track.mesh.clone_from(hash);
            if artist.is_some() {
                track.mesh.extend(body.to_le_bytes());
            }
            if !self.meshes.contains_key(&track.mesh) {
                let unknown = RecordError::UnknownGeometry { body };
                let geometry = recording.geometries.get(hash).ok_or(unknown)?;
                let solid = Solid::try_from(geometry);
                let solid = solid.map_err(|source| RecordError::Geometry { body, source })?;
                let mesh = ExportMesh::of(&solid, geometry, artist);
                self.meshes.insert(track.mesh.clone(), mesh);
            }
        }
        Ok(())
    }

    /// The mesh of a body. Each body of a timeline has one.
    pub(crate) fn mesh(&self, track: &BodyTrack) -> &ExportMesh {
        &self.meshes[&track.mesh]
    }

    /// Names of the objects, in order of their first body.
    pub(crate) fn objects(&self) -> Vec<&str> {
        let mut seen = BTreeSet::new();
        let names = self.bodies.iter().map(|track| track.body.object.as_str());
        names.filter(|name| seen.insert(*name)).collect()
    }
}

fn bodies(recording: &Recording, up: Quat) -> Vec<BodyTrack> {
    let rest = recording.rest_poses();
    let origins = recording.origins();
    let track = |body: &Body| BodyTrack {
        name: String::new(),
        birth: f64::INFINITY,
        death: f64::INFINITY,
        rest: up * rest.get(&body.id).copied().unwrap_or_else(Pose::identity),
        origin: origins.get(&body.id).copied(),
        broke: false,
        mesh: Vec::new(),
        sheets: Vec::new(),
        rows: Vec::new(),
        body: body.clone(),
    };
    let mut tracks: Vec<BodyTrack> = recording.bodies.iter().map(track).collect();
    let ids = (0usize..).zip(&recording.bodies).map(|(at, body)| (body.id, at));
    let mut index: BTreeMap<u64, usize> = ids.collect();
    for poses in &recording.poses {
        for row in PoseRow::of(poses) {
            let Some(track) = index.get(&row.id).map(|&at| &mut tracks[at]) else { continue };
            let turn = Quat::new_normalize((up * row.pose.rotation).into_inner());
            let pose = Pose::from_parts((up * row.pose.translation.vector).into(), turn);
            let (velocity, spin) = (up * row.velocity, up * row.spin);
            track.birth = track.birth.min(poses.time);
            track.rows.push((poses.time, PoseRow { id: row.id, pose, velocity, spin }));
        }
    }
    for event in &recording.events {
        let gone = matches!(event.kind(), EventKind::Fractured | EventKind::Removed);
        if let Some(&at) = event.body.filter(|_| gone).and_then(|id| index.get(&id)) {
            tracks[at].death = event.time;
            tracks[at].broke |= event.kind() == EventKind::Fractured;
        }
    }
    reshape(recording, &mut tracks, &mut index);
    tracks
}

/// A body that got a new shape is another track from then on.
fn reshape(recording: &Recording, tracks: &mut Vec<BodyTrack>, index: &mut BTreeMap<u64, usize>) {
    for shape in &recording.shapes {
        let Some(place) = index.get_mut(&shape.body) else { continue };
        let next = tracks.len();
        let old = &mut tracks[*place];
        let from = old.rows.partition_point(|(time, _)| *time < shape.time);
        let held = from.checked_sub(1).map(|last| old.rows[last].1);
        let mut rows = old.rows.split_off(from);
        // A body that rests has no row at that time: the last one before still holds.
        if let Some(held) = held.filter(|_| rows.first().is_none_or(|row| row.0 > shape.time)) {
            rows.insert(0, (shape.time, held));
        }
        let first = rows.first().map(|row| row.1.pose);
        // A body that moves keeps its centre; one that is fixed keeps its place.
        let moved = held.zip(first).filter(|_| old.body.fixed);
        let moved = moved.map(|(held, first)| held.pose.inv_mul(&first));
        let mut new = BodyTrack {
            birth: shape.time,
            rest: moved.map_or(old.rest, |moved| old.rest * moved),
            rows,
            ..old.clone()
        };
        new.body.geometry.clone_from(&shape.geometry);
        (new.body.mass, new.body.volume) = (shape.mass, shape.volume);
        (old.death, old.broke) = (old.death.min(shape.time), false);
        *place = next;
        tracks.push(new);
    }
}

fn grains(recording: &Recording, up: Quat, range: &FrameRange) -> Vec<GrainTrack> {
    let parents: BTreeMap<u64, &Body> =
        recording.bodies.iter().map(|body| (body.id, body)).collect();
    let mut tracks: BTreeMap<u64, GrainTrack> = BTreeMap::new();
    for grains in &recording.debris {
        let places = grains.positions.as_chunks::<3>().0.iter().map(|&p| up * Vec3::from(p));
        let speeds = grains.velocities.as_chunks::<3>().0.iter().map(|&v| up * Vec3::from(v));
        for (i, ((&id, place), velocity)) in grains.ids.iter().zip(places).zip(speeds).enumerate() {
            let born = grains.sizes.get(i).zip(grains.masses.get(i)).zip(grains.parents.get(i));
            if let Some(((&size, &mass), &parent)) = born {
                let of = parents.get(&parent);
                let name =
                    |text: fn(&Body) -> &String| of.map_or_else(String::new, |b| text(b).clone());
                tracks.insert(
                    id,
                    GrainTrack {
                        id,
                        parent,
                        object: name(|body| &body.object),
                        material: name(|body| &body.material),
                        mass,
                        size,
                        birth: grains.time,
                        rows: Vec::new(),
                    },
                );
            }
            if let Some(track) = tracks.get_mut(&id) {
                track.rows.push((grains.time, place, velocity));
            }
        }
    }
    tracks.into_values().filter(|track| track.birth <= range.end).collect()
}
