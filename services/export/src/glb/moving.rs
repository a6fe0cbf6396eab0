//! Sheets of a GLB: a short one of one surface as a mesh that takes many shapes, any other as a
//! mesh for each of its surfaces.

use super::materials::plain;
use super::{GlbUse, GlbWriter, raw, unit_y_up, y_up};
use crate::moving::{MovingFrame, MovingTrack};
use crate::timeline::Scenery;
use cullet_geometry::Vec3;
use gltf::json;
use json::animation::Property;
use json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use json::validation::Checked;
use json::{Index, Material, Mesh, Node};
use serde_json::json;
use std::collections::BTreeMap;

/// Most frames of a sheet that become shapes of one mesh: programs hold all of them at once.
pub(crate) const MOST_SHAPES: usize = 64;

impl<'a> GlbWriter<'a> {
    /// The sheets; hands back how many.
    pub(super) fn moving(&mut self, scenery: Scenery) -> usize {
        let timeline = self.timeline;
        let tracks = timeline.moving.iter();
        let drawn = tracks.filter(|track| match scenery {
            Scenery::Motion if track.stretches.len() == 1 && track.frames.len() <= MOST_SHAPES => {
                self.shapes(track);
                true
            }
            Scenery::Motion => {
                self.surfaces(track);
                true
            }
            Scenery::Moment(time) => match track.at(time) {
                Some(frame) => {
                    let mesh = self.sheet_mesh(track, &track.name, frame);
                    self.sheet_node(track, &track.name, mesh, [frame.time, f64::INFINITY]);
                    true
                }
                None => false,
            },
            Scenery::Rest => false,
        });
        drawn.count()
    }

    /// One mesh whose shapes are the frames.
    fn shapes(&mut self, track: &MovingTrack) {
        let [first, others @ ..] = &track.frames[..] else { return };
        let mut made = self.sheet_mesh(track, &track.name, first);
        let (normals, count) = (first.normals(), others.len());
        let targets = others.iter().map(|frame| {
            let moved = |(to, from): (&Vec3, &Vec3)| y_up(&(to - from));
            let places: Vec<[f32; 3]> = frame.places.iter().zip(&first.places).map(moved).collect();
            let positions = Some(self.buffer.places(&mut self.root, &places));
            // A page has normals of bytes, from which these would not lead.
            let turned = (self.purpose == GlbUse::Work).then(|| {
                let own = frame.normals();
                let rows: Vec<[f32; 3]> = own.iter().zip(&normals).map(moved).collect();
                self.buffer.normals(&mut self.root, GlbUse::Work, &rows)
            });
            MorphTarget { positions, normals: turned, tangents: None }
        });
        if count > 0 {
            made.primitives[0].targets = Some(targets.collect());
            made.weights = Some(vec![0.0; count]);
            let names = (1..=count).map(|k| format!("frame {k}"));
            made.extras = raw(&json!({ "targetNames": names.collect::<Vec<_>>() }));
        }
        let node = self.sheet_node(track, &track.name, made, track.life(0));
        if count > 0 {
            // At each frame all of its own shape and none of the others.
            let row = |k: usize| (1..=count).map(move |shape| f32::from(u8::from(shape == k)));
            let rows: Vec<[f32; 1]> = (0..=count).flat_map(row).map(|weight| [weight]).collect();
            let times = track.frames.iter().map(|frame| frame.time);
            let keys = self.keys + track.frames.len();
            self.channel(node, Property::MorphTargetWeights, times, &rows);
            self.keys = keys;
        }
    }

    /// A mesh for each surface, as it is at its last frame.
    fn surfaces(&mut self, track: &MovingTrack) {
        for (k, (of, name)) in track.stretches.iter().zip(&track.parts).enumerate() {
            let mesh = self.sheet_mesh(track, name, &track.frames[of.end - 1]);
            self.sheet_node(track, name, mesh, track.life(k));
        }
        self.notes.push(format!(
            "{}: {} frames of {} surfaces are more than a GLB takes as shapes of one mesh \
             ({MOST_SHAPES} of one); each surface is there as at its last frame, and .usda has all",
            track.name,
            track.frames.len(),
            track.stretches.len()
        ));
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

    /// A sheet as it is at one moment.
    fn sheet_mesh(&mut self, track: &MovingTrack, name: &str, frame: &MovingFrame) -> Mesh {
        let places: Vec<[f32; 3]> = frame.places.iter().map(y_up).collect();
        let normals: Vec<[f32; 3]> = frame.normals().iter().map(unit_y_up).collect();
        let indices: Vec<u32> = frame.triangles.iter().flatten().copied().collect();
        self.triangles += frame.triangles.len();
        let material = self.sheet_material(track);
        let (root, buffer) = (&mut self.root, &mut self.buffer);
        let mut attributes = BTreeMap::from([
            (Checked::Valid(Semantic::Positions), buffer.places(root, &places)),
            (Checked::Valid(Semantic::Normals), buffer.normals(root, self.purpose, &normals)),
        ]);
        if let Some(colours) = track.colours(frame) {
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

    /// Seen from both sides; white where the colours of points show a quantity.
    fn sheet_material(&mut self, track: &MovingTrack) -> Index<Material> {
        let [r, g, b] = if track.is_tinted() { [1.0; 3] } else { track.colour };
        let name = format!("{} sheet", track.name);
        let made = Material { double_sided: true, ..plain(name, [r, g, b, 1.0], 0.0, 0.8) };
        self.root.push(made)
    }
}
