//! The bodies of a recording over time.

use super::corners::corner_normals;
use super::sheets::{SheetActor, SheetPlaces};
use cullet_geometry::math::unit;
use cullet_geometry::{Pose, Quat, Sheet, Solid, Surface, TriMesh, Vec3};
use cullet_proto::recording::EventKind;
use cullet_record::palette::{self, Rgb};
use cullet_record::{FragmentOrigin, PoseRow, Recording, Trace, traces};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Stands for the number of any grain.
const GRAIN: u64 = u64::MAX;

/// Stands for the number of any sheet.
const SHEET: u64 = u64::MAX - 1;

/// Least size at which a grain is drawn, as a share of what it broke from \[1\].
const LEAST_SPECK: f64 = 0.006;

/// Width of the line of a crack \[diagonals of its body\], and how far it is above the surface
/// \[half widths\].
const RIBBON: f64 = 0.004;
const RAISED: f64 = 0.4;

/// A mesh ready to be drawn, in the body's frame.
#[derive(Debug)]
pub(super) struct Mesh {
    pub(super) vertices: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The normal at each corner of each triangle.
    pub(super) normals: Vec<[Vec3; 3]>,
    pub(super) crack: Vec<bool>,
    /// Corners of the bounding box.
    pub(super) bounds: [Vec3; 2],
}

/// A body from birth to end.
#[derive(Debug)]
pub(super) struct Actor {
    pub(super) id: u64,
    pub(super) object: String,
    pub(super) fragment: bool,
    /// It has a new shape, or gets one.
    pub(super) deformed: bool,
    /// Mass \[kg\], and where it comes from; nothing where that is not known.
    pub(super) share: Option<(f64, FragmentOrigin)>,
    pub(super) fixed: bool,
    pub(super) outer: Rgb,
    pub(super) inner: Rgb,
    pub(super) mesh: Arc<Mesh>,
    /// When it was where, by time; a body rests between rows.
    pub(super) rows: Vec<(f64, Pose)>,
    /// Velocity of each row \[m/s\].
    pub(super) velocities: Vec<Vec3>,
    /// When it left or broke \[s\].
    pub(super) end: f64,
}

/// A run to be looked at.
#[derive(Debug)]
pub(super) struct Track {
    pub(super) actors: Vec<Actor>,
    /// Grains of debris, as actors that nothing looks after.
    pub(super) specks: Vec<Actor>,
    /// Lines of cracks that end inside bodies, as actors that move with them.
    pub(super) lines: Vec<Actor>,
    /// Bodies that move as they deform.
    pub(super) sheets: Vec<SheetActor>,
    /// What each of them looks like: actors without a mesh.
    pub(super) looks: Vec<Actor>,
    /// When a body broke or took a new shape \[s\], in order, and which.
    pub(super) breaks: Vec<(f64, u64)>,
    /// When a joint broke \[s\], in order.
    pub(super) parted: Vec<f64>,
    /// What was struck by what, in order.
    pub(super) strikes: Vec<(f64, u64, u64)>,
    /// Time step \[s\].
    pub(super) step: f64,
    /// Last recorded time \[s\].
    pub(super) end: f64,
    /// Where the scene wants the pictures to start and to end \[s\].
    pub(super) wanted: [Option<f64>; 2],
    /// Whether the recording has holes.
    pub(super) holes: bool,
    pub(super) up: Vec3,
}

impl Actor {
    /// Where it is, if it is there.
    pub(super) fn at(&self, time: f64) -> Option<&Pose> {
        if time >= self.end {
            return None;
        }
        let next = self.rows.partition_point(|(t, _)| *t <= time);
        self.rows.get(next.checked_sub(1)?).map(|(_, pose)| pose)
    }

    /// The corners of its bounding box in the world.
    pub(super) fn corners(&self, pose: &Pose) -> [Vec3; 8] {
        let [low, high] = self.mesh.bounds;
        std::array::from_fn(|i| {
            let pick = |bit: usize, axis: usize| if i & bit == 0 { low[axis] } else { high[axis] };
            pose.transform_point(&Vec3::new(pick(1, 0), pick(2, 1), pick(4, 2)).into()).coords
        })
    }

    /// Whether it is a grain of debris.
    pub(super) fn is_grain(&self) -> bool {
        self.id == GRAIN
    }

    /// A grain of it: an octahedron of that diameter, turned at random, large enough to be seen.
    fn speck(&self, size: f64, id: u64) -> Self {
        let [low, high] = self.mesh.bounds;
        let half = 0.5 * size.max(LEAST_SPECK * (high - low).norm());
        let draw = |stream: u64| unit(id, stream, 0) - 0.5;
        let turn = Quat::from_scaled_axis(Vec3::new(draw(0), draw(1), draw(2)) * 6.0);
        let ends = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()];
        let vertices = ends.map(|end| turn * end * half).to_vec();
        let sides = [[0, 2], [2, 1], [1, 3], [3, 0]];
        let triangles = sides.iter().flat_map(|&[a, b]| [[a, b, 4], [b, a, 5]]).collect();
        let solid = Solid::outer(TriMesh { vertices, triangles });
        Self {
            id: GRAIN,
            object: self.object.clone(),
            fragment: false,
            deformed: false,
            share: None,
            fixed: false,
            outer: self.inner,
            inner: self.inner,
            mesh: Arc::new(Mesh::of(&solid)),
            rows: Vec::new(),
            velocities: Vec::new(),
            end: f64::INFINITY,
        }
    }

    /// A part of a line that nothing looks after, of one colour, where it is at which times \[s\].
    pub(super) fn line(mesh: Arc<Mesh>, colour: Rgb, rows: Vec<(f64, Pose)>, end: f64) -> Self {
        Self {
            id: GRAIN,
            object: String::new(),
            fragment: false,
            deformed: false,
            share: None,
            fixed: false,
            outer: colour,
            inner: colour,
            mesh,
            velocities: vec![Vec3::zeros(); rows.len()],
            rows,
            end,
        }
    }

    /// What a sheet looks like.
    fn of_sheet(sheet: &SheetActor) -> Self {
        Self {
            id: SHEET,
            object: sheet.name.clone(),
            fragment: false,
            deformed: false,
            share: None,
            fixed: false,
            outer: sheet.colour,
            inner: sheet.colour,
            mesh: Arc::new(Mesh::of(&Solid::outer(TriMesh::default()))),
            rows: Vec::new(),
            velocities: Vec::new(),
            end: f64::INFINITY,
        }
    }

    /// Lines on its surface from some time on, as ribbons just above it.
    fn ribbon(&self, traces: &[Trace], since: f64) -> Self {
        let [low, high] = self.mesh.bounds;
        let half = 0.5 * RIBBON * (high - low).norm();
        let mut mesh = TriMesh::default();
        for &Trace { ends: [p, q], normal } in traces {
            let along = (q - p).try_normalize(0.0).unwrap_or_default() * half;
            let (side, lift) = (normal.cross(&along), normal * (RAISED * half));
            let first = mesh.vertices.len() as u32;
            let (p, q) = (p + lift - 0.5 * along, q + lift + 0.5 * along);
            mesh.vertices.extend([p - side, q - side, q + side, p + side]);
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| first + i)));
        }
        let from = self.rows.partition_point(|(time, _)| *time < since);
        // A body that rests has no row at that time: the last one before still holds.
        let held = from.checked_sub(1).map(|last| (since, self.rows[last].1));
        let held = held.filter(|_| self.rows.get(from).is_none_or(|row| row.0 > since));
        let rows: Vec<(f64, Pose)> =
            held.into_iter().chain(self.rows[from..].iter().copied()).collect();
        Self {
            id: GRAIN,
            object: self.object.clone(),
            fragment: false,
            deformed: false,
            share: None,
            fixed: self.fixed,
            outer: palette::dark(self.outer),
            inner: palette::dark(self.inner),
            mesh: Arc::new(Mesh::of(&Solid::outer(mesh))),
            velocities: vec![Vec3::zeros(); rows.len()],
            rows,
            end: self.end,
        }
    }

    /// Velocity at the last row not after `time` \[m/s\].
    pub(super) fn velocity(&self, time: f64) -> Vec3 {
        let next = self.rows.partition_point(|(t, _)| *t <= time);
        next.checked_sub(1).map_or_else(Vec3::zeros, |i| self.velocities[i])
    }
}

impl Mesh {
    pub(super) fn of(solid: &Solid) -> Self {
        let mesh = &solid.mesh;
        let crack: Vec<bool> =
            solid.surface.iter().map(|s| matches!(s, Surface::Crack { .. })).collect();
        let alike = |t: usize, other: usize| crack[other] == crack[t];
        let normals = corner_normals(&mesh.vertices, &mesh.triangles, alike);
        let mut bounds = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        for vertex in &mesh.vertices {
            bounds = [bounds[0].inf(vertex), bounds[1].sup(vertex)];
        }
        Self {
            normals,
            vertices: mesh.vertices.clone(),
            triangles: mesh.triangles.clone(),
            crack,
            bounds,
        }
    }
}

/// Three numbers of a metadata value.
pub(super) fn vector(text: Option<&String>) -> Option<Vec3> {
    let mut numbers = text?.split_whitespace().map(str::parse::<f64>);
    let mut next = || numbers.next()?.ok().filter(|x| x.is_finite());
    Some(Vec3::new(next()?, next()?, next()?))
}

impl Track {
    /// One without anything.
    pub(super) fn empty(step: f64, up: Vec3) -> Self {
        Self {
            actors: Vec::new(),
            specks: Vec::new(),
            lines: Vec::new(),
            sheets: Vec::new(),
            looks: Vec::new(),
            breaks: Vec::new(),
            parted: Vec::new(),
            strikes: Vec::new(),
            step,
            end: 0.0,
            wanted: [None; 2],
            holes: false,
            up,
        }
    }

    /// Puts a recording together again. What does not fit (a geometry that is no solid, a row of
    /// an unknown body) is left out: a damaged recording still gives a picture.
    pub(super) fn of(recording: &Recording) -> Self {
        let gravity = vector(recording.meta.get("gravity")).unwrap_or_else(Vec3::zeros);
        let time = |key: &str| recording.meta.get(key).and_then(|s| s.parse().ok());
        let up = (-gravity).try_normalize(1e-12).unwrap_or_else(Vec3::z);
        let mut track = Self {
            sheets: SheetActor::all(recording),
            wanted: [time("view.start"), time("view.end")],
            holes: !recording.holes.is_empty(),
            ..Self::empty(time("step").unwrap_or(0.01), up)
        };
        let mut meshes: BTreeMap<&[u8], Arc<Mesh>> = BTreeMap::new();
        for (hash, geometry) in &recording.geometries {
            if let Ok(solid) = Solid::try_from(geometry) {
                meshes.insert(hash, Arc::new(Mesh::of(&solid)));
            }
        }
        let (origins, interiors) = (recording.origins(), recording.interiors());
        let mut index: BTreeMap<u64, usize> = BTreeMap::new();
        for body in &recording.bodies {
            let Some(mesh) = meshes.get(&body.geometry[..]) else {
                continue;
            };
            let (outer, inner) = palette::colours(&body.material, &body.object, body.id);
            let inner = interiors.get(&body.object).map_or(inner, |look| look.colour);
            index.insert(body.id, track.actors.len());
            track.actors.push(Actor {
                id: body.id,
                object: body.object.clone(),
                fragment: body.parent.is_some(),
                deformed: false,
                share: origins.get(&body.id).map(|origin| (body.mass, *origin)),
                fixed: body.fixed,
                outer,
                inner,
                mesh: mesh.clone(),
                rows: Vec::new(),
                velocities: Vec::new(),
                end: f64::INFINITY,
            });
        }
        track.place(recording, &index);
        track.happen(recording, &index);
        track.reshape(recording, &mut index, &meshes);
        track.crumble(recording, &index);
        track.open(recording, &index);
        track.tie(recording, &index);
        track.dress();
        track
    }

    fn place(&mut self, recording: &Recording, index: &BTreeMap<u64, usize>) {
        for poses in &recording.poses {
            self.end = self.end.max(poses.time);
            for row in PoseRow::of(poses) {
                let Some(&actor) = index.get(&row.id) else {
                    continue;
                };
                let turn = Quat::new_normalize(row.pose.rotation.into_inner());
                let pose = Pose::from_parts(row.pose.translation, turn);
                self.actors[actor].rows.push((poses.time, pose));
                self.actors[actor].velocities.push(row.velocity);
            }
        }
    }

    fn happen(&mut self, recording: &Recording, index: &BTreeMap<u64, usize>) {
        for event in &recording.events {
            self.end = self.end.max(event.time);
            if event.kind() == EventKind::JointBroken {
                self.parted.push(event.time);
            }
            let Some(&actor) = event.body.and_then(|id| index.get(&id)) else {
                continue;
            };
            match event.kind() {
                EventKind::Fractured => {
                    self.actors[actor].end = event.time;
                    self.breaks.push((event.time, self.actors[actor].id));
                }
                EventKind::Removed => self.actors[actor].end = event.time,
                EventKind::Impact => {
                    let pair = (self.actors[actor].id, event.striker.unwrap_or(u64::MAX));
                    self.strikes.push((event.time, pair.0, pair.1));
                }
                _ => {}
            }
        }
    }

    /// A body that got a new shape is another actor from then on.
    fn reshape(
        &mut self,
        recording: &Recording,
        index: &mut BTreeMap<u64, usize>,
        meshes: &BTreeMap<&[u8], Arc<Mesh>>,
    ) {
        for shape in &recording.shapes {
            let mesh = meshes.get(&shape.geometry[..]);
            let (Some(mesh), Some(place)) = (mesh, index.get_mut(&shape.body)) else {
                continue;
            };
            let next = self.actors.len();
            self.breaks.push((shape.time, shape.body));
            let old = &mut self.actors[*place];
            old.deformed = true;
            let from = old.rows.partition_point(|(time, _)| *time < shape.time);
            let new = Actor {
                object: old.object.clone(),
                share: old.share.map(|(_, origin)| (shape.mass, origin)),
                mesh: mesh.clone(),
                rows: old.rows.split_off(from),
                velocities: old.velocities.split_off(from),
                ..*old
            };
            old.end = old.end.min(shape.time);
            *place = next;
            self.actors.push(new);
        }
        self.breaks.sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// Grains, each as a small solid in the colour of the crack faces of what it broke from.
    fn crumble(&mut self, recording: &Recording, index: &BTreeMap<u64, usize>) {
        let mut known: BTreeMap<u64, usize> = BTreeMap::new();
        for grains in &recording.debris {
            for (i, &id) in grains.ids.iter().enumerate() {
                let Some(&[x, y, z]) = grains.positions.as_chunks::<3>().0.get(i) else {
                    continue;
                };
                let born = grains.sizes.get(i).zip(grains.parents.get(i));
                if let Some((size, parent)) = born.filter(|_| !known.contains_key(&id))
                    && let Some(parent) = index.get(parent).map(|&parent| &self.actors[parent])
                {
                    known.insert(id, self.specks.len());
                    let speck = parent.speck(*size, id);
                    self.specks.push(speck);
                }
                if let Some(speck) = known.get(&id).map(|&k| &mut self.specks[k]) {
                    speck.rows.push((grains.time, Pose::translation(x, y, z)));
                }
            }
        }
    }

    /// Cracks that end inside bodies, each as a ribbon on the surface of its body.
    fn open(&mut self, recording: &Recording, index: &BTreeMap<u64, usize>) {
        for cracks in &recording.cracks {
            let hash = recording.geometry_of(cracks.body, cracks.step);
            let solid = hash.and_then(|hash| recording.geometries.get(hash));
            let solid = solid.and_then(|geometry| Solid::try_from(geometry).ok());
            let (Some(&actor), Some(solid)) = (index.get(&cracks.body), solid) else {
                continue;
            };
            let Ok(sheet) = Sheet::try_from(cracks) else {
                continue;
            };
            let traces = traces(&solid.mesh, &sheet);
            if !traces.is_empty() {
                self.lines.push(self.actors[actor].ribbon(&traces, cracks.time));
            }
        }
    }

    /// What sheets look like.
    fn dress(&mut self) {
        for sheet in &self.sheets {
            self.end = self.end.max(sheet.end());
            self.looks.push(Actor::of_sheet(sheet));
        }
    }

    /// The sheets there at a time, and where. Their numbers follow those of [`Track::present`].
    pub(super) fn sheets_at(
        &self,
        time: f64,
    ) -> impl Iterator<Item = (u32, &SheetActor, Cow<'_, SheetPlaces>)> {
        let first = self.actors.len() + self.specks.len() + self.lines.len();
        let numbered = (first as u32..).zip(&self.sheets);
        numbered.filter_map(move |(i, sheet)| Some((i, sheet, sheet.at(time)?)))
    }

    /// The sheet of that number.
    pub(super) fn sheet(&self, who: u32) -> Option<&SheetActor> {
        self.sheets.get(self.place_of_sheet(who)?)
    }

    fn place_of_sheet(&self, who: u32) -> Option<usize> {
        let others = self.actors.len() + self.specks.len() + self.lines.len();
        (who as usize).checked_sub(others)
    }

    /// The bodies there at a time, and where; then the grains and the lines.
    pub(super) fn present(&self, time: f64) -> impl Iterator<Item = (u32, &Actor, &Pose)> {
        let all = self.actors.iter().chain(&self.specks).chain(&self.lines);
        let numbered = (0u32..).zip(all);
        numbered.filter_map(move |(i, actor)| Some((i, actor, actor.at(time)?)))
    }

    /// Whom [`Track::present`] or [`Track::sheets_at`] gives that number.
    pub(super) fn actor(&self, who: u32) -> &Actor {
        if let Some(look) = self.place_of_sheet(who).and_then(|sheet| self.looks.get(sheet)) {
            return look;
        }
        let (who, bodies, specks) = (who as usize, self.actors.len(), self.specks.len());
        let speck = |who: usize| self.specks.get(who - bodies);
        let actor = self.actors.get(who).or_else(|| speck(who));
        actor.unwrap_or_else(|| &self.lines[who - bodies - specks])
    }
}
