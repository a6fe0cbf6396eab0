//! GLB: a node a body, with its motion as an animation. Up is y there.

mod buffer;
mod materials;
mod moving;
mod sheets;

use crate::error::ExportError;
use crate::keys;
use crate::looks::{icosahedron, linear};
use crate::surface::{ExportFace, ExportMesh, FaceKind};
use crate::timeline::{BodyTrack, ExportTimeline, FrameRange, GrainTrack, Scenery};
use buffer::GlbBuffer;
pub(crate) use buffer::GlbUse;
use cullet_geometry::{Pose, Quat, Vec3};
use cullet_proto::recording::Tier;
use cullet_record::FragmentOrigin;
use gltf::json;
use json::animation::{Channel, Interpolation, Property, Sampler, Target};
use json::extras::RawValue;
use json::mesh::{Mode, Primitive, Semantic};
use json::scene::UnitQuaternion;
use json::validation::Checked;
use json::{Accessor, Animation, Image, Index, Material, Mesh, Node, Root, Scene};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};

/// Most grains that become nodes, the largest first: importers take long over thousands of nodes.
pub(crate) const MOST_GRAINS: usize = 1_000;
/// How far a key of a grain that is left out may be from the line between its neighbours, over the
/// diameter of the grain \[1\].
const GRAIN_SHARE: f64 = 0.01;

/// The extension of glTF that has normals of bytes.
const QUANTIZATION: &str = "KHR_mesh_quantization";
/// On a page: how far a key that is left out may be from the line between its neighbours, over the
/// diagonal of its body \[1\], and by how much it may be turned \[rad\]. Neither is seen.
const PAGE_SHARE: f64 = 1e-4;
/// See [`PAGE_SHARE`].
const PAGE_TURN: f64 = 1e-3;

/// What was written.
#[derive(Clone, Debug, Default)]
pub(crate) struct GlbContent {
    pub(crate) bytes: Vec<u8>,
    pub(crate) bodies: usize,
    pub(crate) grains: usize,
    pub(crate) keys: usize,
    pub(crate) triangles: usize,
    pub(crate) pictures: usize,
    pub(crate) sheets: usize,
    /// What the reader should know of it.
    pub(crate) notes: Vec<String>,
}

/// Our z is up, glTF's y: a turn about x.
fn y_up(v: &Vec3) -> [f32; 3] {
    [v.x as f32, v.z as f32, -v.y as f32]
}

/// The same rotation in glTF's axes: x, y, z, w.
fn turn_y_up(q: &Quat) -> [f32; 4] {
    [q.i as f32, q.k as f32, -q.j as f32, q.w as f32]
}

fn raw(value: &Value) -> Option<Box<RawValue>> {
    serde_json::value::to_raw_value(value).ok()
}

/// Faces of one kind, as accessors.
struct FaceAccessors {
    attributes: BTreeMap<Checked<Semantic>, Index<Accessor>>,
    indices: Index<Accessor>,
}

struct GlbWriter<'a> {
    timeline: &'a ExportTimeline,
    purpose: GlbUse,
    root: Root,
    buffer: GlbBuffer,
    animation: Animation,
    /// Faces of each mesh, by kind.
    primitives: BTreeMap<&'a [u8], Vec<(FaceKind, FaceAccessors)>>,
    meshes: BTreeMap<(&'a [u8], &'a str), Index<Mesh>>,
    materials: BTreeMap<&'a str, BTreeMap<FaceKind, Index<Material>>>,
    /// Pictures by name.
    images: BTreeMap<&'a str, Index<Image>>,
    nodes: Vec<Index<Node>>,
    keys: usize,
    triangles: usize,
    notes: Vec<String>,
}

/// Writes a timeline. `of`: which of its bodies.
pub(crate) fn write(
    timeline: &ExportTimeline,
    scenery: Scenery,
    purpose: GlbUse,
    of: impl Fn(&BodyTrack) -> bool,
) -> Result<GlbContent, ExportError> {
    let mut writer = GlbWriter {
        timeline,
        purpose,
        root: Root::default(),
        buffer: GlbBuffer::new(),
        animation: Animation {
            name: Some(timeline.scene.clone()).filter(|name| !name.is_empty()),
            channels: Vec::new(),
            samplers: Vec::new(),
            extensions: None,
            extras: None,
        },
        primitives: BTreeMap::new(),
        meshes: BTreeMap::new(),
        materials: BTreeMap::new(),
        images: BTreeMap::new(),
        nodes: Vec::new(),
        keys: 0,
        triangles: 0,
        notes: Vec::new(),
    };
    let bodies: Vec<&BodyTrack> = timeline.bodies.iter().filter(|track| of(track)).collect();
    bodies.iter().for_each(|track| writer.body(track, scenery));
    let count = bodies.len();
    let grains = writer.grains(scenery);
    let sheets = writer.moving(scenery);
    let content = GlbContent { bodies: count, grains, sheets, ..GlbContent::default() };
    writer.finish(content)
}

impl<'a> GlbWriter<'a> {
    fn body(&mut self, track: &'a BodyTrack, scenery: Scenery) {
        let range = &self.timeline.range;
        let pose = match scenery {
            Scenery::Moment(time) => track.at(time, range).pose,
            Scenery::Motion | Scenery::Rest => track.rest,
        };
        // A program that plays no animation shows what is there at first.
        let hidden = scenery == Scenery::Motion && !track.is_there(range.start);
        let (mesh, children) = (self.mesh(track), self.sheets(track, scenery));
        let node = self.root.push(Node {
            name: Some(track.name.clone()),
            mesh: Some(mesh),
            children,
            translation: Some(y_up(&pose.translation.vector)),
            rotation: Some(UnitQuaternion(turn_y_up(&pose.rotation))),
            scale: hidden.then_some([0.0; 3]),
            extras: raw(&self.facts(track)),
            ..Node::default()
        });
        self.nodes.push(node);
        if scenery == Scenery::Motion {
            self.motion(track, node);
            self.visibility(node, [track.birth, track.death], 1.0);
        }
    }

    /// What a program shows of a node as its own properties.
    fn facts(&self, track: &BodyTrack) -> Value {
        let (body, range) = (&track.body, &self.timeline.range);
        let tier = Tier::try_from(body.tier).unwrap_or_default();
        let mut facts = json!({
            "id": body.id,
            "object": body.object,
            "material": body.material,
            "mass_kg": body.mass,
            "volume_m3": body.volume,
            "generation": body.generation,
            "tier": format!("{tier:?}").to_lowercase(),
            "fixed": body.fixed,
            "birth_s": range.since(track.birth),
        });
        if let Some(parent) = body.parent {
            facts["parent"] = parent.into();
        }
        if track.death.is_finite() {
            facts["end_s"] = range.since(track.death).into();
        }
        if let Some(sampled) = track.is_of(FragmentOrigin::Sampled) {
            facts["sampled"] = sampled.into();
        }
        if track.origin == Some(FragmentOrigin::Directed) {
            facts["directed"] = true.into();
        }
        if let Some([low, high]) = self.timeline.mesh(track).damage_range() {
            (facts["damage_time_min_s"], facts["damage_time_max_s"]) = (low.into(), high.into());
        }
        facts
    }

    fn mesh(&mut self, track: &'a BodyTrack) -> Index<Mesh> {
        self.materials(track);
        let (mesh, object) = (&track.mesh[..], &track.body.object[..]);
        self.triangles += self.timeline.mesh(track).faces.len();
        if let Some(&known) = self.meshes.get(&(mesh, object)) {
            return known;
        }
        if !self.primitives.contains_key(mesh) {
            let parts = self.face_kinds(self.timeline.mesh(track));
            self.primitives.insert(mesh, parts);
        }
        let materials = &self.materials[object];
        let primitives = self.primitives[mesh].iter().map(|(kind, part)| Primitive {
            attributes: part.attributes.clone(),
            indices: Some(part.indices),
            material: materials.get(kind).copied(),
            mode: Checked::Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        });
        let made = Mesh {
            // Not the node's: three.js calls the parts of a mesh NAME_1, NAME_2, and finds what an
            // animation moves by its name, which must not be that of a part.
            name: Some(format!("{}.mesh", track.name)),
            primitives: primitives.collect(),
            weights: None,
            extensions: None,
            extras: None,
        };
        let index = self.root.push(made);
        self.meshes.insert((mesh, object), index);
        index
    }

    /// The faces of a mesh, kind by kind.
    fn face_kinds(&mut self, mesh: &ExportMesh) -> Vec<(FaceKind, FaceAccessors)> {
        let mut kinds: BTreeMap<FaceKind, Vec<&ExportFace>> = BTreeMap::new();
        mesh.faces.iter().for_each(|face| kinds.entry(face.kind()).or_default().push(face));
        kinds.iter().map(|(&kind, faces)| (kind, self.primitive(mesh, faces))).collect()
    }

    /// Faces of one kind, as vertices that differ and their indices.
    fn primitive(&mut self, mesh: &ExportMesh, faces: &[&ExportFace]) -> FaceAccessors {
        // A page lays no picture on crack faces.
        let textured = faces.iter().all(|face| {
            face.uv.is_some() && (self.purpose == GlbUse::Work || face.crack.is_none())
        });
        let crack = faces.iter().all(|face| face.crack.is_some());
        let mut known: HashMap<(u32, [u32; 3], [u32; 2], u32), u32> = HashMap::new();
        let (mut places, mut normals, mut textures) = (Vec::new(), Vec::new(), Vec::new());
        let mut damage_times: Vec<[f32; 1]> = Vec::new();
        let mut indices = Vec::with_capacity(3 * faces.len());
        for face in faces {
            for k in 0..3 {
                let normal = unit_y_up(&face.normals[k]);
                // glTF counts v from the top of the picture.
                let uv =
                    face.uv.filter(|_| textured).map_or([0.0; 2], |uv| [uv[k][0], 1.0 - uv[k][1]]);
                let damage_time = face.crack.map_or(0.0, |mark| mark.damage_time[k]);
                let (normal_bits, uv_bits) = (normal.map(f32::to_bits), uv.map(f32::to_bits));
                let key = (face.corners[k], normal_bits, uv_bits, damage_time.to_bits());
                indices.push(*known.entry(key).or_insert_with(|| {
                    places.push(y_up(&mesh.vertices[face.corners[k] as usize]));
                    normals.push(normal);
                    textures.push(uv);
                    damage_times.push([damage_time]);
                    places.len() as u32 - 1
                }));
            }
        }
        let (root, buffer) = (&mut self.root, &mut self.buffer);
        let mut attributes = BTreeMap::new();
        let place = buffer.places(root, &places);
        attributes.insert(Checked::Valid(Semantic::Positions), place);
        let normal = buffer.normals(root, self.purpose, &normals);
        attributes.insert(Checked::Valid(Semantic::Normals), normal);
        if textured {
            let texture = buffer.textures(root, &textures);
            attributes.insert(Checked::Valid(Semantic::TexCoords(0)), texture);
        }
        if crack {
            let times = buffer.marks(root, &damage_times);
            attributes.insert(Checked::Valid(Semantic::Extras("DAMAGE_TIME".to_owned())), times);
        }
        FaceAccessors { attributes, indices: buffer.indices(root, &indices) }
    }

    /// Keys of places and rotations, where it does not stay where its node puts it.
    fn motion(&mut self, track: &BodyTrack, node: Index<Node>) {
        let range = &self.timeline.range;
        let times = track.samples(range);
        let poses: Vec<Pose> = times.iter().map(|&time| track.at(time, range).pose).collect();
        let places: Vec<Vec3> = poses.iter().map(|pose| pose.translation.vector).collect();
        let mut turns: Vec<Quat> = poses.iter().map(|pose| pose.rotation).collect();
        keys::continuous(&mut turns);
        let diagonal = self.timeline.mesh(track).diagonal;
        let (bound, turn) = match self.purpose {
            GlbUse::Work => (keys::PLACE_MOST.min(keys::PLACE_SHARE * diagonal), keys::TURN_MOST),
            GlbUse::Page => (PAGE_SHARE * diagonal, PAGE_TURN),
        };
        let kept = keys::of_vectors(&times, &places, bound);
        if kept.len() > 1 || places[0] != track.rest.translation.vector {
            let rows: Vec<[f32; 3]> = kept.iter().map(|&k| y_up(&places[k])).collect();
            let at = kept.iter().map(|&k| times[k]);
            self.channel(node, Property::Translation, at, &rows);
        }
        let kept = keys::of_turns(&times, &turns, turn);
        if kept.len() > 1 || turns[0] != track.rest.rotation {
            let rows: Vec<[f32; 4]> = kept.iter().map(|&k| turn_y_up(&turns[k])).collect();
            let at = kept.iter().map(|&k| times[k]);
            self.channel(node, Property::Rotation, at, &rows);
        }
    }

    /// Visible or not is a scale of 1 or 0 that jumps: programs do not animate visibility itself.
    fn visibility(&mut self, node: Index<Node>, [birth, death]: [f64; 2], size: f32) {
        let range: FrameRange = self.timeline.range;
        let (born, gone) = (birth > range.start, death <= range.end);
        if !born && !gone {
            return;
        }
        let mut keys = vec![(range.start, if born { 0.0 } else { size })];
        keys.extend(born.then_some((birth, size)));
        keys.extend(gone.then_some((death, 0.0)));
        let rows: Vec<[f32; 3]> = keys.iter().map(|&(_, size)| [size; 3]).collect();
        self.channel(node, Property::Scale, keys.iter().map(|key| key.0), &rows);
    }

    fn channel<const N: usize>(
        &mut self,
        node: Index<Node>,
        path: Property,
        times: impl Iterator<Item = f64>,
        rows: &[[f32; N]],
    ) {
        let range = &self.timeline.range;
        let times: Vec<f32> = times.map(|time| range.since(time) as f32).collect();
        let input = self.buffer.times(&mut self.root, &times);
        let output = self.buffer.keys(&mut self.root, rows);
        let interpolation = match path {
            Property::Scale => Interpolation::Step,
            _ => Interpolation::Linear,
        };
        self.keys += rows.len();
        let sampler = Index::new(self.animation.samplers.len() as u32);
        self.animation.samplers.push(Sampler {
            input,
            output,
            interpolation: Checked::Valid(interpolation),
            extensions: None,
            extras: None,
        });
        self.animation.channels.push(Channel {
            sampler,
            target: Target { node, path: Checked::Valid(path), extensions: None, extras: None },
            extensions: None,
            extras: None,
        });
    }

    /// Grains, the largest first, under a node of their own; hands back how many.
    fn grains(&mut self, scenery: Scenery) -> usize {
        let timeline = self.timeline;
        let there = |grain: &&GrainTrack| match scenery {
            Scenery::Motion => true,
            Scenery::Moment(time) => grain.birth <= time,
            Scenery::Rest => false,
        };
        let mut grains: Vec<&GrainTrack> = timeline.grains.iter().filter(there).collect();
        grains.sort_by(|a, b| b.size.total_cmp(&a.size));
        grains.truncate(MOST_GRAINS);
        let mut balls: BTreeMap<&str, Index<Mesh>> = BTreeMap::new();
        let mut children = Vec::with_capacity(grains.len());
        for grain in &grains {
            let ball = match balls.get(&grain.object[..]) {
                Some(&ball) => ball,
                None => {
                    let ball = self.ball(grain);
                    balls.insert(&grain.object, ball);
                    ball
                }
            };
            children.push(self.grain(grain, ball, scenery));
        }
        if !children.is_empty() {
            let (name, children) = (Some("grains".to_owned()), Some(children));
            let node = self.root.push(Node { name, children, ..Node::default() });
            self.nodes.push(node);
        }
        grains.len()
    }

    fn grain(&mut self, grain: &GrainTrack, mesh: Index<Mesh>, scenery: Scenery) -> Index<Node> {
        let range = &self.timeline.range;
        let at = if let Scenery::Moment(time) = scenery { time } else { grain.birth };
        let hidden = scenery == Scenery::Motion && grain.birth > range.start;
        // The ball has a diameter of 1.
        let size = grain.size as f32;
        let facts = json!({ "grain": grain.id, "parent": grain.parent, "mass_kg": grain.mass,
            "diameter_m": grain.size, "birth_s": range.since(grain.birth) });
        let node = self.root.push(Node {
            name: Some(format!("grain_{}", grain.id)),
            mesh: Some(mesh),
            translation: Some(y_up(&grain.at(at, range).0)),
            scale: Some(if hidden { [0.0; 3] } else { [size; 3] }),
            extras: raw(&facts),
            ..Node::default()
        });
        if scenery == Scenery::Motion {
            let times = grain.samples(range);
            let places: Vec<Vec3> = times.iter().map(|&time| grain.at(time, range).0).collect();
            let kept = keys::of_vectors(&times, &places, GRAIN_SHARE * grain.size);
            if kept.len() > 1 || grain.birth < range.start {
                let rows: Vec<[f32; 3]> = kept.iter().map(|&k| y_up(&places[k])).collect();
                let at = kept.iter().map(|&k| times[k]);
                self.channel(node, Property::Translation, at, &rows);
            }
            self.visibility(node, [grain.birth, f64::INFINITY], size);
        }
        node
    }

    /// A ball of diameter 1 in the colour of an object's crack faces.
    fn ball(&mut self, grain: &GrainTrack) -> Index<Mesh> {
        let look = self.timeline.look(&grain.material, &grain.object, false);
        let [r, g, b] = linear(look.crack);
        let name = format!("{} grains", grain.object);
        let material = self.plain(name, [r, g, b, 1.0], look.roughness);
        let (corners, faces) = icosahedron();
        let places: Vec<[f32; 3]> = corners.iter().map(|corner| y_up(&(corner * 0.5))).collect();
        let normals: Vec<[f32; 3]> = corners.iter().map(unit_y_up).collect();
        let indices: Vec<u32> = faces.iter().flatten().copied().collect();
        let (root, buffer) = (&mut self.root, &mut self.buffer);
        let place = buffer.places(root, &places);
        let normal = buffer.normals(root, self.purpose, &normals);
        let primitive = Primitive {
            attributes: BTreeMap::from([
                (Checked::Valid(Semantic::Positions), place),
                (Checked::Valid(Semantic::Normals), normal),
            ]),
            indices: Some(buffer.indices(root, &indices)),
            material: Some(material),
            mode: Checked::Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        };
        root.push(Mesh {
            name: Some(format!("{} grain", grain.object)),
            primitives: vec![primitive],
            weights: None,
            extensions: None,
            extras: None,
        })
    }

    fn finish(mut self, content: GlbContent) -> Result<GlbContent, ExportError> {
        if !self.animation.channels.is_empty() {
            self.root.push(self.animation);
        }
        // With a hyphen, which no node's name has. three.js finds what moves by name, the scene's
        // included: next to a scene `pane` it calls the body `pane` as its first piece, `pane_1`.
        let scene = self.root.push(Scene {
            name: Some(format!("{}-scene", self.timeline.scene)),
            nodes: self.nodes,
            extensions: None,
            extras: None,
        });
        self.root.scene = Some(scene);
        if self.purpose == GlbUse::Page {
            self.root.extensions_used.push(QUANTIZATION.to_owned());
            self.root.extensions_required.push(QUANTIZATION.to_owned());
        }
        self.root.asset.generator = Some(format!("Cullet {}", env!("CARGO_PKG_VERSION")));
        let bin = self.buffer.finish(&mut self.root);
        let text = self.root.to_vec().map_err(|error| ExportError::Encode(error.to_string()))?;
        let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
        let glb = gltf::binary::Glb { header, json: Cow::Owned(text), bin: Some(Cow::Owned(bin)) };
        let bytes = glb.to_vec().map_err(|error| ExportError::Encode(error.to_string()))?;
        let (keys, triangles, pictures) = (self.keys, self.triangles, self.images.len());
        Ok(GlbContent { bytes, keys, triangles, pictures, notes: self.notes, ..content })
    }
}

/// A unit vector whose rounded numbers are one too.
fn unit_y_up(normal: &Vec3) -> [f32; 3] {
    y_up(&normal.try_normalize(1e-300).unwrap_or_else(Vec3::z))
}
