//! The prims of sheets: a mesh for each surface, whose points have samples in time.

use super::samples::{list, samples, scales, single, triple, visibility};
use crate::moving::{MovingFrame, MovingTrack};
use crate::timeline::{ExportTimeline, FrameRange, Scenery};
use cullet_geometry::Vec3;
use cullet_record::PlacedSheet;
use std::borrow::Cow;
use std::fmt::{Display, Write};
use std::ops::Range;

const INDENT: &str = "            ";
/// End of a primvar that has a value at each point.
const VERTEX: &str = "(\n                interpolation = \"vertex\"\n            )";

/// A mesh: its name, its frames, and from when to when it is seen \[s\].
type SheetPrim<'a> = (&'a str, Cow<'a, [MovingFrame]>, [f64; 2]);

/// Writes text below a mesh.
struct MeshWriter<'a> {
    text: &'a mut String,
    range: &'a FrameRange,
    keys: usize,
}

/// What was written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MovingContent {
    pub(super) sheets: usize,
    pub(super) keys: usize,
    pub(super) triangles: usize,
}

/// Writes the sheets. The material of each is called as it is, with `_sheet`.
pub(super) fn write(
    text: &mut String,
    timeline: &ExportTimeline,
    scenery: Scenery,
) -> MovingContent {
    let mut content = MovingContent::default();
    for track in &timeline.moving {
        let look = format!("{}_sheet", track.name);
        let meshes: Vec<SheetPrim<'_>> = match scenery {
            Scenery::Motion => {
                let parts = track.parts.iter().zip(&track.stretches).enumerate();
                let of = |stretch: &Range<usize>| (&track.frames[stretch.clone()]).into();
                parts.map(|(k, (name, part))| (&name[..], of(part), track.life(k))).collect()
            }
            Scenery::Moment(time) => {
                let one = track.at(time).map(|frame| Cow::Owned(vec![frame]));
                let always = [f64::NEG_INFINITY, f64::INFINITY];
                one.map(|frame| (&track.parts[0][..], frame, always)).into_iter().collect()
            }
            Scenery::Rest => Vec::new(),
        };
        if meshes.is_empty() {
            continue;
        }
        let _ = writeln!(text, "    def Xform \"{}\" (", track.name);
        let _ = writeln!(text, "        kind = \"component\"\n    )\n    {{");
        let _ = writeln!(text, "        custom int userProperties:sheet = {}", track.number);
        let _ = writeln!(text, "        double3 xformOp:translate = {}", triple(&track.origin));
        let _ = writeln!(text, "        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n");
        for (name, frames, life) in meshes {
            let mut writer = MeshWriter { text, range: &timeline.range, keys: 0 };
            writer.mesh(track, (name, &look), &frames, life);
            content.keys += writer.keys;
            content.triangles += frames[0].shape.triangles.len();
        }
        text.push_str("    }\n\n");
        content.sheets += 1;
    }
    content
}

impl MeshWriter<'_> {
    fn line(&mut self, line: impl Display) {
        let _ = writeln!(self.text, "{INDENT}{line}");
    }

    /// A value by the number of its frame, and its samples where there are several frames.
    fn varies(
        &mut self,
        attribute: &str,
        end: &str,
        frames: &[MovingFrame],
        value: impl Fn(usize) -> String,
    ) {
        self.line(format_args!("{attribute} = {}{end}", value(0)));
        if frames.len() > 1 {
            let code = |frame: &MovingFrame| self.range.since(frame.time) * self.range.fps;
            let all: Vec<(f64, String)> =
                frames.iter().enumerate().map(|(k, frame)| (code(frame), value(k))).collect();
            self.keys += all.len();
            samples(self.text, INDENT, attribute, all);
        }
    }

    fn mesh(
        &mut self,
        track: &MovingTrack,
        (name, look): (&str, &str),
        frames: &[MovingFrame],
        life: [f64; 2],
    ) {
        let shape = &frames[0].shape;
        let placed: Vec<PlacedSheet> = frames.iter().map(MovingFrame::placed).collect();
        let triangles = &shape.triangles;
        let _ = writeln!(self.text, "        def Mesh \"{name}\" (");
        self.line("prepend apiSchemas = [\"MaterialBindingAPI\"]\n        )\n        {");
        // Both faces of a closed one are there, so close that their backs would shine through.
        let double = u8::from(!shape.is_thick());
        self.line(format_args!("uniform bool doubleSided = {double}"));
        self.line(format_args!("int[] faceVertexCounts = {}", list(triangles.iter().map(|_| 3))));
        let corners = list(triangles.iter().flatten());
        self.line(format_args!("int[] faceVertexIndices = {corners}"));
        self.line("uniform token orientation = \"rightHanded\"");
        self.line("uniform token subdivisionScheme = \"none\"");
        self.line(format_args!("rel material:binding = </World/Looks/{look}>"));
        self.varies("float3[] extent", "", frames, |k| {
            let bounds = cullet_geometry::mesh::bounds(&placed[k].places);
            let (low, high) = bounds.unwrap_or_default();
            list([single(&low), single(&high)])
        });
        self.varies("point3f[] points", "", frames, |k| vectors(&placed[k].places));
        let end = format!(" {VERTEX}");
        self.varies("normal3f[] primvars:normals", &end, frames, |k| vectors(&placed[k].normals));
        if track.is_tinted() {
            self.varies("float[] primvars:quantity", &end, frames, |k| list(frames[k].values()));
            self.varies("color3f[] primvars:displayColor", &end, frames, |k| {
                let colours = track.colours(&frames[k]).unwrap_or_default();
                list(colours.iter().map(|[r, g, b]| format!("({r}, {g}, {b})")))
            });
        }
        self.appears(life);
        self.text.push_str("        }\n\n");
    }

    /// When it is seen: by visibility, and by a scale for programs that ignore that.
    fn appears(&mut self, life: [f64; 2]) {
        let range = self.range;
        let [birth, death] = life.map(|time| (time - range.start) * range.fps);
        let seen = visibility(birth, death, range.since(range.end) * range.fps);
        if seen.len() == 1 {
            return;
        }
        let word = |there: bool| if there { "\"inherited\"" } else { "\"invisible\"" };
        let words = seen.iter().map(|&(time, there)| (time, word(there)));
        samples(self.text, INDENT, "token visibility", words);
        self.line("float3 xformOp:scale = (1, 1, 1)");
        samples(self.text, INDENT, "float3 xformOp:scale", scales(&seen));
        self.line("uniform token[] xformOpOrder = [\"xformOp:scale\"]");
        self.keys += 2 * seen.len();
    }
}

fn vectors(all: &[Vec3]) -> String {
    list(all.iter().map(single))
}
