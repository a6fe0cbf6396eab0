//! Sheets of a GLB: meshes that take many shapes, each for the frames of one surface.

use super::materials::plain;
use super::{GlbUse, GlbWriter, raw, unit_y_up, y_up};
use crate::looks::finish;
use crate::moving::{MovingFrame, MovingTrack, ShapeRun};
use crate::timeline::Scenery;
use cullet_geometry::Vec3;
use cullet_record::PlacedSheet;
use gltf::json;
use json::animation::Property;
use json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use json::validation::Checked;
use json::{Index, Material, Mesh, Node};
use serde_json::json;
use std::collections::BTreeMap;

/// Most bytes of the shapes of a sheet; of a longer one every second or third frame becomes a
/// shape, or fewer.
const MOST_BYTES: usize = 96 << 20;
/// The same on a page.
const PAGE_BYTES: usize = 12 << 20;
/// Bytes of a place or a normal.
const TRIPLE: usize = 12;

impl<'a> GlbWriter<'a> {
    /// The sheets; hands back how many.
    pub(super) fn moving(&mut self, scenery: Scenery) -> usize {
        let timeline = self.timeline;
        let tracks = timeline.moving.iter();
        let drawn = tracks.filter(|track| match scenery {
            Scenery::Motion => {
                self.runs(track);
                true
            }
            Scenery::Moment(time) => match track.at(time) {
                Some(frame) => {
                    let material = self.sheet_material(track);
                    let mesh = self.sheet_mesh(track, &track.name, (&frame, &frame), material);
                    let life = [frame.time, f64::INFINITY];
                    self.sheet_node(track, &track.name, mesh, life);
                    true
                }
                None => false,
            },
            Scenery::Rest => false,
        });
        drawn.count()
    }

    /// A mesh for each run of frames, seen one after another.
    fn runs(&mut self, track: &MovingTrack) {
        let (row, most) = match self.purpose {
            GlbUse::Work => (2 * TRIPLE, MOST_BYTES),
            GlbUse::Page => (TRIPLE, PAGE_BYTES),
        };
        let bytes = |run: &ShapeRun| {
            let frames = &track.frames[run.frames.clone()];
            (frames.len() - 1) * frames[0].shape.vertices.len() * row
        };
        let every = track.runs.iter().map(bytes).sum::<usize>().div_ceil(most).max(1);
        let material = self.sheet_material(track);
        for (k, run) in track.runs.iter().enumerate() {
            self.shapes(track, run, (every, track.run_life(k)), material);
        }
        if every > 1 {
            self.notes.push(format!(
                "{}: of {} frames a GLB has only every {every}th as a shape, and straight ways \
                 between them: more would be over {} MB; .usda has all",
                track.name,
                track.frames.len(),
                most >> 20
            ));
        }
    }

    /// One mesh whose shapes are frames of one surface.
    fn shapes(
        &mut self,
        track: &MovingTrack,
        run: &ShapeRun,
        (every, life): (usize, [f64; 2]),
        material: Index<Material>,
    ) {
        let frames = &track.frames[run.frames.clone()];
        let last = frames.len() - 1;
        let kept = (0..last).step_by(every).chain([last]);
        let kept: Vec<&MovingFrame> = kept.map(|k| &frames[k]).collect();
        let (first, count) = (frames[0].placed(), kept.len() - 1);
        let pair = (kept[0], &frames[last / 2]);
        let mut made = self.sheet_mesh(track, &run.name, pair, material);
        let shapes = kept[1..].iter().map(|frame| self.shape(&first, &frame.placed()));
        let shapes: Vec<MorphTarget> = shapes.collect();
        if count > 0 {
            made.primitives[0].targets = Some(shapes);
            made.weights = Some(vec![0.0; count]);
            let names = (1..=count).map(|k| format!("frame {k}"));
            made.extras = raw(&json!({ "targetNames": names.collect::<Vec<_>>() }));
        }
        let node = self.sheet_node(track, &run.name, made, life);
        if count > 0 {
            // At each frame all of its own shape and none of the others.
            let row = |k: usize| (1..=count).map(move |shape| f32::from(u8::from(shape == k)));
            let rows: Vec<[f32; 1]> = (0..=count).flat_map(row).map(|weight| [weight]).collect();
            let times = kept.iter().map(|frame| frame.time);
            let keys = self.keys + kept.len();
            self.channel(node, Property::MorphTargetWeights, times, &rows);
            self.keys = keys;
        }
    }

    /// What leads from the first shape to another.
    fn shape(&mut self, first: &PlacedSheet, own: &PlacedSheet) -> MorphTarget {
        let moved = |(to, from): (&Vec3, &Vec3)| y_up(&(to - from));
        let places: Vec<[f32; 3]> = own.places.iter().zip(&first.places).map(moved).collect();
        let positions = Some(self.buffer.places(&mut self.root, &places));
        // A page has normals of bytes, from which these would not lead.
        let normals = (self.purpose == GlbUse::Work).then(|| {
            let rows: Vec<[f32; 3]> = own.normals.iter().zip(&first.normals).map(moved).collect();
            self.buffer.normals(&mut self.root, GlbUse::Work, &rows)
        });
        MorphTarget { positions, normals, tangents: None }
    }

    fn sheet_node(
        &mut self,
        track: &MovingTrack,
        name: &str,
        mesh: Mesh,
        [birth, death]: [f64; 2],
    ) -> Index<Node> {
        let (mesh, range) = (self.root.push(mesh), self.timeline.range);
        let hidden = birth > range.start;
        let facts = json!({ "sheet": track.number, "material": track.material,
            "birth_s": range.since(birth) });
        let node = self.root.push(Node {
            name: Some(name.to_owned()),
            mesh: Some(mesh),
            translation: Some(y_up(&track.origin)),
            scale: hidden.then_some([0.0; 3]),
            extras: raw(&facts),
            ..Node::default()
        });
        self.nodes.push(node);
        self.visibility(node, [birth, death], 1.0);
        node
    }

    /// A sheet as it is at one moment, in the colours of perhaps another one of the same surface.
    fn sheet_mesh(
        &mut self,
        track: &MovingTrack,
        name: &str,
        (frame, coloured): (&MovingFrame, &MovingFrame),
        material: Index<Material>,
    ) -> Mesh {
        let placed = frame.placed();
        let places: Vec<[f32; 3]> = placed.places.iter().map(y_up).collect();
        let normals: Vec<[f32; 3]> = placed.normals.iter().map(unit_y_up).collect();
        let indices: Vec<u32> = frame.shape.triangles.iter().flatten().copied().collect();
        self.triangles += frame.shape.triangles.len();
        let (root, buffer) = (&mut self.root, &mut self.buffer);
        let mut attributes = BTreeMap::from([
            (Checked::Valid(Semantic::Positions), buffer.places(root, &places)),
            (Checked::Valid(Semantic::Normals), buffer.normals(root, self.purpose, &normals)),
        ]);
        if let Some(colours) = track.colours(coloured) {
            let colours = buffer.normals(root, GlbUse::Work, &colours);
            attributes.insert(Checked::Valid(Semantic::Colors(0)), colours);
        }
        let primitive = Primitive {
            attributes,
            indices: Some(buffer.indices(root, &indices)),
            material: Some(material),
            mode: Checked::Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        };
        Mesh {
            name: Some(format!("{name}.mesh")),
            primitives: vec![primitive],
            weights: None,
            extensions: None,
            extras: None,
        }
    }

    /// White where the colours of points show a quantity. Of a sheet with both faces only the
    /// outside is seen: they are so close that the other would shine through.
    fn sheet_material(&mut self, track: &MovingTrack) -> Index<Material> {
        let [r, g, b] = if track.is_tinted() { [1.0; 3] } else { track.colour };
        // A page has no surroundings that a metal could mirror.
        let [metallic, roughness] = finish(track.metal && self.purpose == GlbUse::Work);
        let name = format!("{} sheet", track.name);
        let double_sided = !track.frames.iter().all(|frame| frame.shape.is_thick());
        let made = plain(name, [r, g, b, 1.0], metallic, roughness);
        self.root.push(Material { double_sided, ..made })
    }
}
