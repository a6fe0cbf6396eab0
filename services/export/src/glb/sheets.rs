//! Cracks that end inside a body, as nodes below its own.

use super::materials::plain;
use super::{GlbUse, GlbWriter, raw};
use crate::looks::linear;
use crate::surface::{ExportFace, FaceKind};
use crate::timeline::{BodyTrack, Scenery};
use gltf::json;
use json::mesh::{Mode, Primitive};
use json::validation::Checked;
use json::{Index, Material, Mesh, Node};
use serde_json::json;

impl<'a> GlbWriter<'a> {
    /// The nodes of a body's cracks. A page has none: what is inside a body is not seen there.
    pub(super) fn sheets(
        &mut self,
        track: &'a BodyTrack,
        scenery: Scenery,
    ) -> Option<Vec<Index<Node>>> {
        let there = |birth: f64| match scenery {
            Scenery::Moment(time) => birth <= time,
            Scenery::Motion | Scenery::Rest => true,
        };
        let mut nodes = Vec::new();
        let wanted = self.purpose == GlbUse::Work;
        for sheet in track.sheets.iter().filter(|sheet| wanted && there(sheet.birth)) {
            let faces: Vec<&ExportFace> = sheet.mesh.faces.iter().collect();
            let part = self.primitive(&sheet.mesh, &faces);
            self.triangles += faces.len();
            let primitive = Primitive {
                attributes: part.attributes,
                indices: Some(part.indices),
                material: Some(self.open_crack(track)),
                mode: Checked::Valid(Mode::Triangles),
                targets: None,
                extensions: None,
                extras: None,
            };
            let mesh = self.root.push(Mesh {
                name: Some(format!("{}.mesh", sheet.name)),
                primitives: vec![primitive],
                weights: None,
                extensions: None,
                extras: None,
            });
            let range = &self.timeline.range;
            // It goes with its body, whose scale it has, too.
            let later = scenery == Scenery::Motion
                && sheet.birth > track.birth
                && sheet.birth > range.start;
            let facts =
                json!({ "open_crack_of": track.body.id, "birth_s": range.since(sheet.birth) });
            let node = self.root.push(Node {
                name: Some(sheet.name.clone()),
                mesh: Some(mesh),
                scale: later.then_some([0.0; 3]),
                extras: raw(&facts),
                ..Node::default()
            });
            if later {
                self.visibility(node, [sheet.birth, f64::INFINITY], 1.0);
            }
            nodes.push(node);
        }
        Some(nodes).filter(|nodes| !nodes.is_empty())
    }

    /// The material of an object's crack faces, for what is seen from both sides.
    fn open_crack(&mut self, track: &'a BodyTrack) -> Index<Material> {
        let body = &track.body;
        let kind = FaceKind::OpenCrack;
        if let Some(&known) = self.materials.get(&body.object[..]).and_then(|of| of.get(&kind)) {
            return known;
        }
        let look = self.timeline.look(&body.material, &body.object, body.fixed);
        let [r, g, b] = linear(look.crack);
        let name = format!("{} open crack", body.object);
        let made =
            Material { double_sided: true, ..plain(name, [r, g, b, 1.0], 0.0, look.roughness) };
        let made = self.root.push(made);
        self.materials.entry(&body.object).or_default().insert(kind, made);
        made
    }
}
