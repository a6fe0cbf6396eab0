//! The prim of a body.

use super::samples::{list, quaternion, samples, scales, single, triple, visibility};
use crate::keys;
use crate::sheets::CrackSheet;
use crate::surface::{CrackMark, ExportFace, ExportMesh, FaceKind};
use crate::timeline::{BodyTrack, ExportTimeline, FrameRange, Scenery};
use cullet_geometry::{Pose, Quat, Vec3};
use cullet_record::PoseRow;
use std::collections::{BTreeMap, HashMap};
use std::fmt::{Display, Write};

/// How far a sample of a velocity \[m/s\] or a spin \[degrees/s\] that is left out may be from the
/// line between its neighbours: they only blur.
const BLUR: f64 = 1e-3;

const INDENT: &str = "            ";

/// Ends of primvars, which say of what there is a value: of the body, of each face, of each corner.
const CONSTANT: &str = "    interpolation = \"constant\"\n            )";
const UNIFORM: &str = "    interpolation = \"uniform\"\n            )";
const FACE_VARYING: &str = "    interpolation = \"faceVarying\"\n            )";

/// Writes prims below an object.
pub(super) struct PrimWriter<'a> {
    pub(super) text: &'a mut String,
    pub(super) keys: usize,
}

/// Values at corners, each once, and which each corner has.
struct IndexedValues<const N: usize> {
    values: Vec<[f32; N]>,
    known: HashMap<[u32; N], usize>,
    indices: Vec<usize>,
}

impl<const N: usize> IndexedValues<N> {
    fn push(&mut self, value: [f32; N]) {
        let index = *self.known.entry(value.map(f32::to_bits)).or_insert_with(|| {
            self.values.push(value);
            self.values.len() - 1
        });
        self.indices.push(index);
    }

    fn text(&self) -> String {
        let vector = |value: &[f32; N]| match &value[..] {
            [one] => one.to_string(),
            _ => format!("({})", value.map(|number| number.to_string()).join(", ")),
        };
        list(self.values.iter().map(vector))
    }
}

impl PrimWriter<'_> {
    fn line(&mut self, line: impl Display) {
        let _ = writeln!(self.text, "{INDENT}{line}");
    }

    /// A body; `look`: the name of its object, which its materials have too.
    pub(super) fn body(
        &mut self,
        timeline: &ExportTimeline,
        track: &BodyTrack,
        scenery: Scenery,
        look: &str,
    ) {
        let mesh = timeline.mesh(track);
        let _ = writeln!(self.text, "        def Mesh \"{}\" (", track.name);
        let physics = ["\"PhysicsRigidBodyAPI\"", "\"PhysicsMassAPI\""];
        let physics = &physics[usize::from(track.body.fixed)..];
        let schemas = list(["\"MaterialBindingAPI\""].iter().chain(physics));
        let _ = writeln!(self.text, "{INDENT}prepend apiSchemas = {schemas}");
        let _ = writeln!(self.text, "{INDENT}kind = \"component\"\n        )\n        {{");
        self.facts(timeline, track);
        self.mesh(mesh, &format!("{look}_skin"));
        self.line(format_args!("string primvars:piecename = \"{}\" (", track.name));
        self.line(CONSTANT);
        match scenery {
            Scenery::Motion => self.motion(timeline, track),
            Scenery::Moment(time) => self.place(&track.at(time, &timeline.range).pose),
            Scenery::Rest => self.place(&track.rest),
        }
        self.subsets(mesh, look);
        self.text.push_str("        }\n\n");
    }

    /// A crack that ends inside a body. It stands beside that: a mesh has no mesh below it.
    pub(super) fn sheet(
        &mut self,
        timeline: &ExportTimeline,
        (track, sheet): (&BodyTrack, &CrackSheet),
        scenery: Scenery,
        look: &str,
    ) {
        let range = &timeline.range;
        let _ = writeln!(self.text, "        def Mesh \"{}\" (", sheet.name);
        self.line("prepend apiSchemas = [\"MaterialBindingAPI\"]\n        )\n        {");
        self.line(format_args!("custom int64 userProperties:open_crack_of = {}", track.body.id));
        self.line(format_args!(
            "custom double userProperties:birth = {}",
            range.since(sheet.birth)
        ));
        self.line("uniform bool doubleSided = 1");
        self.mesh(&sheet.mesh, &format!("{look}_crack"));
        match scenery {
            Scenery::Motion => {
                self.moves(timeline, track);
                self.appears(range, [sheet.birth, track.death]);
            }
            Scenery::Moment(time) => self.place(&track.at(time, range).pose),
            Scenery::Rest => self.place(&track.rest),
        }
        self.text.push_str("        }\n\n");
    }

    fn facts(&mut self, timeline: &ExportTimeline, track: &BodyTrack) {
        let (body, range) = (&track.body, &timeline.range);
        self.line(format_args!("float physics:mass = {}", body.mass as f32));
        if !body.fixed {
            // The recorded motion moves it, not a physics engine, until somebody unticks this.
            self.line("bool physics:kinematicEnabled = 1");
        }
        self.line(format_args!("custom int64 userProperties:id = {}", body.id));
        self.line(format_args!("custom double userProperties:mass = {}", body.mass));
        self.line(format_args!(
            "custom double userProperties:birth = {}",
            range.since(track.birth)
        ));
        if let Some(parent) = body.parent {
            self.line(format_args!("custom int64 userProperties:parent = {parent}"));
        }
        if let Some([low, high]) = timeline.mesh(track).damage_range() {
            self.line(format_args!("custom float2 userProperties:damage_time = ({low}, {high})"));
        }
    }

    /// `look`: the name of its material.
    fn mesh(&mut self, mesh: &ExportMesh, look: &str) {
        let corners = || mesh.faces.iter().flat_map(|face| face.corners);
        let [low, high] = mesh.bounds();
        self.line(format_args!("float3[] extent = {}", list([single(&low), single(&high)])));
        let counts = list(mesh.faces.iter().map(|_| 3));
        self.line(format_args!("int[] faceVertexCounts = {counts}"));
        self.line(format_args!("int[] faceVertexIndices = {}", list(corners())));
        let points = list(mesh.vertices.iter().map(single));
        self.line(format_args!("point3f[] points = {points}"));
        self.line("uniform token orientation = \"rightHanded\"");
        self.line("uniform token subdivisionScheme = \"none\"");
        self.line(format_args!("rel material:binding = </World/Looks/{look}>"));
        let normal = |face: &ExportFace, k: usize| face.normals[k].map(|x| x as f32).into();
        self.corners("normal3f[] primvars:normals", mesh, normal);
        if mesh.faces.iter().any(|face| face.uv.is_some()) {
            self.corners("texCoord2f[] primvars:st", mesh, |face, k| {
                face.uv.map_or([0.0; 2], |uv| uv[k])
            });
        }
        if mesh.faces.iter().any(|face| face.crack.is_some()) {
            let mark = |face: &ExportFace| {
                face.crack.unwrap_or(CrackMark { parent: -1, ..CrackMark::default() })
            };
            let time = |face: &ExportFace, k: usize| [mark(face).damage_time[k]];
            self.corners("float[] primvars:damage_time", mesh, time);
            let speed = |face: &ExportFace, k: usize| [mark(face).front_speed[k]];
            self.corners("float[] primvars:front_speed", mesh, speed);
            let parents = list(mesh.faces.iter().map(|face| mark(face).parent));
            self.line(format_args!("int[] primvars:parent_id = {parents} ("));
            self.line(UNIFORM);
        }
    }

    /// A primvar with a value at each corner.
    fn corners<const N: usize>(
        &mut self,
        name: &str,
        mesh: &ExportMesh,
        value: impl Fn(&ExportFace, usize) -> [f32; N],
    ) {
        let (values, known, indices) = (Vec::new(), HashMap::new(), Vec::new());
        let mut all = IndexedValues { values, known, indices };
        for face in &mesh.faces {
            (0..3).for_each(|k| all.push(value(face, k)));
        }
        self.line(format_args!("{name} = {} (", all.text()));
        self.line(FACE_VARYING);
        let plain = name.rsplit(' ').next().unwrap_or(name);
        self.line(format_args!("int[] {plain}:indices = {}", list(&all.indices)));
    }

    /// Skin and crack faces, each with its material; the skin by the materials of its file.
    fn subsets(&mut self, mesh: &ExportMesh, look: &str) {
        self.line("uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"");
        let mut kinds: BTreeMap<FaceKind, Vec<usize>> = BTreeMap::new();
        for (index, face) in mesh.faces.iter().enumerate() {
            kinds.entry(face.kind()).or_default().push(index);
        }
        for (kind, faces) in kinds {
            let part = match kind {
                FaceKind::Skin => "skin".to_owned(),
                FaceKind::Slot(slot) => format!("slot_{slot}"),
                FaceKind::Crack | FaceKind::OpenCrack => "crack".to_owned(),
            };
            let indices = list(faces);
            let _ = write!(
                self.text,
                "\n{INDENT}def GeomSubset \"{part}\" (\n{INDENT}    \
                 prepend apiSchemas = [\"MaterialBindingAPI\"]\n{INDENT})\n{INDENT}{{\n{INDENT}    \
                 uniform token elementType = \"face\"\n{INDENT}    \
                 uniform token familyName = \"materialBind\"\n{INDENT}    \
                 int[] indices = {indices}\n{INDENT}    \
                 rel material:binding = </World/Looks/{look}_{part}>\n{INDENT}}}\n"
            );
        }
    }

    /// Where it is, without motion.
    fn place(&mut self, pose: &Pose) {
        self.line(format_args!("double3 xformOp:translate = {}", triple(&pose.translation.vector)));
        self.line(format_args!("quatd xformOp:orient = {}", quaternion(&pose.rotation)));
        self.order("");
    }

    fn order(&mut self, scale: &str) {
        self.line(format_args!(
            "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"{scale}]"
        ));
    }

    /// Time samples, with those that blur.
    fn motion(&mut self, timeline: &ExportTimeline, track: &BodyTrack) {
        let range = &timeline.range;
        self.moves(timeline, track);
        if !track.body.fixed {
            let times = track.samples(range);
            let rows: Vec<PoseRow> = times.iter().map(|&time| track.at(time, range)).collect();
            let frames: Vec<f64> =
                times.iter().map(|time| range.since(*time) * range.fps).collect();
            let speeds: Vec<Vec3> = rows.iter().map(|row| row.velocity).collect();
            let spins = rows.iter().map(|row| row.spin.map(f64::to_degrees));
            let spins: Vec<Vec3> = spins.collect();
            for (name, values) in [("velocity", speeds), ("angularVelocity", spins)] {
                let kept = keys::of_vectors(&times, &values, BLUR);
                let all = kept.iter().map(|&k| (frames[k], single(&values[k])));
                self.samples(&format!("vector3f physics:{name}"), all);
            }
        }
        self.appears(range, [track.birth, track.death]);
    }

    /// Samples of place and rotation. What has no sample at a time, as before the first, is the
    /// rest pose.
    fn moves(&mut self, timeline: &ExportTimeline, track: &BodyTrack) {
        let range = &timeline.range;
        let times = track.samples(range);
        let poses: Vec<Pose> = times.iter().map(|&time| track.at(time, range).pose).collect();
        let frames: Vec<f64> = times.iter().map(|&time| range.since(time) * range.fps).collect();
        let places: Vec<Vec3> = poses.iter().map(|pose| pose.translation.vector).collect();
        let mut turns: Vec<Quat> = poses.iter().map(|pose| pose.rotation).collect();
        keys::continuous(&mut turns);
        let rest = &track.rest;
        self.line(format_args!("double3 xformOp:translate = {}", triple(&rest.translation.vector)));
        let bound = keys::PLACE_MOST.min(keys::PLACE_SHARE * timeline.mesh(track).diagonal);
        let kept = keys::of_vectors(&times, &places, bound);
        if kept.len() > 1 || places[0] != rest.translation.vector {
            let all = kept.iter().map(|&k| (frames[k], triple(&places[k])));
            self.samples("double3 xformOp:translate", all);
        }
        self.line(format_args!("quatd xformOp:orient = {}", quaternion(&rest.rotation)));
        let kept = keys::of_turns(&times, &turns, keys::TURN_MOST);
        if kept.len() > 1 || turns[0] != rest.rotation {
            let all = kept.iter().map(|&k| (frames[k], quaternion(&turns[k])));
            self.samples("quatd xformOp:orient", all);
        }
    }

    /// When it is seen, and the order of what moves it.
    fn appears(&mut self, range: &FrameRange, [birth, death]: [f64; 2]) {
        let frame = |time: f64| (time - range.start) * range.fps;
        let seen = visibility(frame(birth), frame(death), range.since(range.end) * range.fps);
        if seen.len() == 1 {
            return self.order("");
        }
        let word = |there: bool| if there { "\"inherited\"" } else { "\"invisible\"" };
        self.samples("token visibility", seen.iter().map(|&(time, there)| (time, word(there))));
        self.line("float3 xformOp:scale = (1, 1, 1)");
        self.samples("float3 xformOp:scale", scales(&seen));
        self.order(", \"xformOp:scale\"");
    }

    fn samples<T: Display>(&mut self, attribute: &str, all: impl IntoIterator<Item = (f64, T)>) {
        let all: Vec<(f64, T)> = all.into_iter().collect();
        self.keys += all.len();
        samples(self.text, INDENT, attribute, all);
    }
}
