//! USD as text: a prim a body under its object, with time samples. Up is z.

mod grains;
mod materials;
mod moving;
mod prim;
mod samples;

use crate::looks::{ObjectLook, finish, linear};
use crate::moving::MovingTrack;
use crate::names::UniqueNames;
use crate::sheets::CrackSheet;
use crate::timeline::{BodyTrack, ExportTimeline, Scenery};
use materials::{artist, of_points, plain};
use prim::PrimWriter;
use std::collections::BTreeMap;
use std::fmt::Write;

/// What was written.
#[derive(Clone, Debug, Default)]
pub(crate) struct UsdContent {
    pub(crate) text: String,
    pub(crate) bodies: usize,
    pub(crate) keys: usize,
    pub(crate) triangles: usize,
    pub(crate) sheets: usize,
}

/// A text between quotation marks.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

fn head(timeline: &ExportTimeline, scenery: Scenery) -> String {
    let (range, mut text) = (&timeline.range, String::from("#usda 1.0\n(\n"));
    let version = env!("CARGO_PKG_VERSION");
    let about = format!("Exported by Cullet {version} from the scene {}", timeline.scene);
    let _ = writeln!(text, "    defaultPrim = \"World\"\n    doc = {}", quoted(&about));
    if scenery == Scenery::Motion {
        let last = range.since(range.end) * range.fps;
        let _ = writeln!(text, "    startTimeCode = 0\n    endTimeCode = {last}");
        let _ =
            writeln!(text, "    timeCodesPerSecond = {0}\n    framesPerSecond = {0}", range.fps);
    }
    text.push_str("    kilogramsPerUnit = 1\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n\n");
    text
}

/// `folder`: where its pictures lie, from where the file lies.
pub(crate) fn write(timeline: &ExportTimeline, scenery: Scenery, folder: &str) -> UsdContent {
    let mut content = UsdContent { text: head(timeline, scenery), ..UsdContent::default() };
    content.text.push_str("def Xform \"World\" (\n    kind = \"assembly\"\n)\n{\n");
    let there = |track: &&BodyTrack| match scenery {
        Scenery::Moment(time) => track.is_there(time),
        Scenery::Motion | Scenery::Rest => true,
    };
    let mut names = UniqueNames::default();
    // Names of prims beside the objects.
    let taken = ["Looks", "Grains"].map(|name| names.give(name));
    let mut objects: BTreeMap<&str, String> = BTreeMap::new();
    let mut looks = String::new();
    for object in timeline.objects() {
        let name = names.give(object);
        let of = timeline.bodies.iter().find(|track| track.body.object == object);
        if let Some(body) = of.map(|track| &track.body) {
            let ObjectLook { skin, crack, roughness } =
                timeline.look(&body.material, object, body.fixed);
            looks += &plain(&format!("{name}_skin"), linear(skin), 0.0, 0.5);
            looks += &plain(&format!("{name}_crack"), linear(crack), 0.0, roughness);
        }
        let own = timeline.bodies.iter().filter(|track| track.body.object == object);
        let slots = own.map(|track| &timeline.mesh(track).materials).max_by_key(|of| of.len());
        for (slot, of) in slots.into_iter().flat_map(|of| of.iter()).enumerate() {
            looks += &artist(&format!("{name}_slot_{slot}"), of, folder);
        }
        objects.insert(object, name);
    }
    let of_sheet = |track: &MovingTrack| match track.is_tinted() {
        true => of_points(&format!("{}_sheet", track.name), 0.8),
        false => {
            let [metallic, roughness] = finish(track.metal);
            plain(&format!("{}_sheet", track.name), track.colour, metallic, roughness)
        }
    };
    looks.extend(timeline.moving.iter().map(of_sheet));
    let _ = write!(content.text, "    def Scope \"{}\"\n    {{\n{looks}    }}\n\n", taken[0]);
    for object in timeline.objects() {
        let look = &objects[object];
        let _ = writeln!(content.text, "    def Xform \"{look}\" (");
        let _ = writeln!(content.text, "        kind = \"group\"\n    )\n    {{");
        let own = timeline.bodies.iter().filter(|track| track.body.object == object);
        for track in own.filter(there) {
            let mut prim = PrimWriter { text: &mut content.text, keys: 0 };
            prim.body(timeline, track, scenery, look);
            let born = |sheet: &&CrackSheet| match scenery {
                Scenery::Moment(time) => sheet.birth <= time,
                Scenery::Motion | Scenery::Rest => true,
            };
            for sheet in track.sheets.iter().filter(born) {
                prim.sheet(timeline, (track, sheet), scenery, look);
                content.triangles += sheet.mesh.faces.len();
            }
            content.keys += prim.keys;
            content.bodies += 1;
            content.triangles += timeline.mesh(track).faces.len();
        }
        content.text.push_str("    }\n\n");
    }
    grains::write(&mut content.text, timeline, scenery, &objects);
    let moving = moving::write(&mut content.text, timeline, scenery);
    content.sheets = moving.sheets;
    (content.keys, content.triangles) =
        (content.keys + moving.keys, content.triangles + moving.triangles);
    content.text.push_str("}\n");
    content
}
