//! Grains of debris, as instances of a ball an object.

use super::samples::{list, samples, single};
use crate::timeline::{ExportTimeline, GrainTrack, Scenery};
use cullet_geometry::Vec3;
use std::collections::BTreeMap;
use std::fmt::Write;

const INDENT: &str = "        ";

/// Grains at one time: all that are born by then.
struct GrainSample<'a> {
    /// Time \[frames\].
    frame: f64,
    grains: Vec<(&'a GrainTrack, Vec3, Vec3)>,
}

impl<'a> GrainSample<'a> {
    fn of(timeline: &'a ExportTimeline, time: f64) -> Self {
        let range = &timeline.range;
        let born = timeline.grains.iter().filter(|grain| grain.birth <= time);
        let at = |grain: &'a GrainTrack| {
            let (place, velocity) = grain.at(time, range);
            (grain, place, velocity)
        };
        Self { frame: range.since(time) * range.fps, grains: born.map(at).collect() }
    }

    fn extent(&self) -> String {
        let mut bounds = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        for (grain, place, _) in &self.grains {
            let half = Vec3::repeat(0.5 * grain.size);
            bounds = [bounds[0].inf(&(place - half)), bounds[1].sup(&(place + half))];
        }
        match self.grains.is_empty() {
            true => list(bounds.map(|_| single(&Vec3::zeros()))),
            false => list(bounds.iter().map(single)),
        }
    }

    fn ids(&self) -> String {
        list(self.grains.iter().map(|(grain, ..)| grain.id))
    }

    /// The prototype of each: the place of its object among `kinds`.
    fn prototypes(&self, kinds: &[&str]) -> String {
        let kind = |object: &str| kinds.binary_search(&object).unwrap_or(0);
        list(self.grains.iter().map(|(grain, ..)| kind(&grain.object)))
    }

    /// Diameters, which scale a ball of diameter 1.
    fn widths(&self) -> String {
        list(self.grains.iter().map(|(grain, ..)| single(&Vec3::repeat(grain.size))))
    }

    fn places(&self) -> String {
        list(self.grains.iter().map(|(_, place, _)| single(place)))
    }

    fn velocities(&self) -> String {
        list(self.grains.iter().map(|(.., velocity)| single(velocity)))
    }
}

/// When grains have to be looked at: at births, and at each frame while one flies.
fn times(timeline: &ExportTimeline) -> Vec<f64> {
    let range = &timeline.range;
    let own = timeline.grains.iter().flat_map(|grain| grain.samples(range));
    let mut times: Vec<f64> = own.chain([range.start]).collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    times
}

pub(super) fn write(
    text: &mut String,
    timeline: &ExportTimeline,
    scenery: Scenery,
    objects: &BTreeMap<&str, String>,
) {
    let all: Vec<GrainSample<'_>> = match scenery {
        Scenery::Motion => {
            times(timeline).into_iter().map(|time| GrainSample::of(timeline, time)).collect()
        }
        Scenery::Moment(time) => vec![GrainSample::of(timeline, time)],
        Scenery::Rest => Vec::new(),
    };
    if all.iter().all(|sample| sample.grains.is_empty()) {
        return;
    }
    let mut kinds: Vec<&str> = timeline.grains.iter().map(|grain| &grain.object[..]).collect();
    kinds.sort_unstable();
    kinds.dedup();
    text.push_str("    def PointInstancer \"Grains\"\n    {\n");
    let balls = list((0..kinds.len()).map(|k| format!("</World/Grains/ball_{k}>")));
    let _ = writeln!(text, "{INDENT}rel prototypes = {balls}");
    // What does not change while none is born is written at births only.
    let born = |k: &usize| *k == 0 || all[k - 1].grains.len() != all[*k].grains.len();
    let births: Vec<usize> = (0..all.len()).filter(born).collect();
    let mut put = |name: &str, which: &[usize], value: &dyn Fn(&GrainSample<'_>) -> String| {
        let rows = which.iter().map(|&k| (all[k].frame, value(&all[k])));
        match scenery {
            Scenery::Motion => samples(text, INDENT, name, rows),
            Scenery::Moment(_) | Scenery::Rest => {
                let _ = writeln!(text, "{INDENT}{name} = {}", value(&all[0]));
            }
        }
    };
    let every: Vec<usize> = (0..all.len()).collect();
    put("int64[] ids", &births, &|sample| sample.ids());
    put("int[] protoIndices", &births, &|sample| sample.prototypes(&kinds));
    put("float3[] scales", &births, &|sample| sample.widths());
    put("point3f[] positions", &every, &|sample| sample.places());
    put("vector3f[] velocities", &every, &|sample| sample.velocities());
    put("float3[] extent", &every, &|sample| sample.extent());
    for (k, object) in kinds.iter().enumerate() {
        // A ball of diameter 1: the scale of an instance is its diameter.
        let _ = write!(
            text,
            "\n{INDENT}def Sphere \"ball_{k}\" (\n{INDENT}    \
             prepend apiSchemas = [\"MaterialBindingAPI\"]\n{INDENT})\n{INDENT}{{\n{INDENT}    \
             double radius = 0.5\n{INDENT}    \
             float3[] extent = [(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)]\n"
        );
        if let Some(name) = objects.get(object) {
            let _ =
                writeln!(text, "{INDENT}    rel material:binding = </World/Looks/{name}_crack>");
        }
        let _ = writeln!(text, "{INDENT}}}");
    }
    text.push_str("    }\n");
}
